// SPDX-License-Identifier: Apache-2.0
#include "covis/exchange/point_adjustment.h"

#include "covis/optimization/bundle_adjustment.h"

namespace covis::exchange {
namespace {

constexpr double kSigma = 1;  // a keypoint's, against depths and for what is an outlier, pixels

}  // namespace

void adjust_points(Scene& scene) {
  BundleProblem problem;
  problem.camera = scene.cameras[0].refined;
  for (const ScenePoint& point : scene.points) problem.points.push_back(point.position);
  for (const SceneView& view : scene.views) {
    const Pinhole& camera = scene.cameras[view.camera].pinhole;
    const double zoom = problem.camera.fx / camera.fx;
    for (const SceneView::Keypoint& keypoint : view.keypoints) {
      const Eigen::Vector2d at = problem.camera.project(camera.unproject(keypoint.u, keypoint.v));
      const double sigma = zoom * kSigma;
      problem.observations.push_back({.pose = static_cast<int32_t>(problem.poses.size()),
                                      .point = static_cast<int32_t>(keypoint.point),
                                      .u = static_cast<float>(at.x()),
                                      .v = static_cast<float>(at.y()),
                                      .inv_sigma2 = static_cast<float>(1 / (sigma * sigma)),
                                      .disparity = keypoint.disparity});
    }
    problem.poses.push_back(view.T_cw);
    problem.fixed.push_back(1);
  }
  BundleAdjuster().solve(problem, {.iterations = 20});
  for (size_t i = 0; i < scene.points.size(); ++i) scene.points[i].position = problem.points[i];
  find_sights(scene);
}

}  // namespace covis::exchange
