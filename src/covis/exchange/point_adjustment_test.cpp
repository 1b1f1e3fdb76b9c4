// SPDX-License-Identifier: Apache-2.0
#include "covis/exchange/point_adjustment.h"

#include "covis/exchange/test_scene.h"

namespace covis::exchange {
namespace {

// The ring's first submap, and where its points are.
class PointAdjustment : public testing::Test {
 protected:
  // The greatest distance of a point from where it is, as a share of its own from the first view that sees it.
  double worst() const {
    double worst = 0;
    for (size_t i = 0; i < scene.points.size(); ++i) {
      const Eigen::Vector3d& at = exact.points[i].position;
      const double far = (exact.views[exact.points[i].seen[0].view].T_cw * at).norm();
      worst = std::max(worst, (scene.points[i].position - at).norm() / far);
    }
    return worst;
  }
  const Scene exact = ring_scenes()[0];
  Scene scene = exact;
};

TEST_F(PointAdjustment, PutsPointsWhereTheyAreSeenAndHoldsPoses) {
  for (size_t i = 0; i < scene.points.size(); ++i) scene.points[i].position *= i % 2 ? 1.03 : 0.97;
  ASSERT_GT(worst(), 0.02);
  adjust_points(scene);
  EXPECT_LT(worst(), 1e-3);
  EXPECT_LT(mean_error(scene), 0.01) << "the points' errors follow";
  for (size_t v = 0; v < scene.views.size(); ++v) EXPECT_EQ(scene.views[v].T_cw.t(), exact.views[v].T_cw.t());
}

TEST_F(PointAdjustment, WeighsKeypointsOfAllLevelsAlike) {
  const auto is_often_seen = [](const ScenePoint& point) { return point.seen.size() >= 4; };
  const auto point = std::find_if(scene.points.begin(), scene.points.end(), is_often_seen);
  ASSERT_NE(point, scene.points.end());
  double least = 1e9, greatest = -1e9;
  for (size_t k = 0; k < point->seen.size(); ++k) {
    SceneView::Keypoint& keypoint = scene.views[point->seen[k].view].keypoints[point->seen[k].keypoint];
    keypoint.v += k % 2 ? 0.5 : -0.5;
    keypoint.scale = k % 2 ? 3 : 1;
  }
  adjust_points(scene);
  for (const auto& [v, k] : point->seen) {
    const SceneView& view = scene.views[v];
    const double error = view.keypoints[k].v - scene.cameras[0].pinhole.project(view.T_cw * point->position).y();
    least = std::min(least, error);
    greatest = std::max(greatest, error);
  }
  EXPECT_NEAR(greatest, 0.5, 0.2);
  EXPECT_NEAR(least, -0.5, 0.2);
}

TEST_F(PointAdjustment, KeepsTheDepthOfAPointThatOneViewSees) {
  ScenePoint& point = scene.points[0];
  for (size_t k = 1; k < point.seen.size(); ++k) {
    auto& keypoints = scene.views[point.seen[k].view].keypoints;
    keypoints.erase(keypoints.begin() + point.seen[k].keypoint);
  }
  const Eigen::Vector3d centre = scene.views[point.seen[0].view].T_cw.inverse().t();
  point.position = centre + 1.05 * (point.position - centre);
  adjust_points(scene);
  EXPECT_LT(worst(), 2e-3);
}

}  // namespace
}  // namespace covis::exchange
