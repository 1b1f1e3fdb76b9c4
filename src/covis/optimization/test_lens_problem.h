// SPDX-License-Identifier: Apache-2.0
// For tests: points seen through a lens by a camera that moves.
#pragma once

#include <cmath>
#include <vector>

#include "covis/core/random.h"
#include "covis/geometry/camera.h"
#include "covis/optimization/lens_adjustment.h"

namespace covis::lens_test {

inline constexpr int kViews = 16;
inline constexpr double kFocal = 500, kPixelNoise = 0.3;  // pixels

enum class Motion { sideways, ahead };

inline Camera camera_with(const Lens& lens) {
  Camera camera{.width = 640, .height = 480, .pinhole = {lens.focal, lens.focal, 320, 240, 0}};
  camera.distortion = Distortion::brown_conrady;
  camera.coefficients[0] = lens.k1;
  camera.coefficients[1] = lens.k2;
  return camera;
}

// Adds a point that is at `place` and that the map has at `claim`, with the pixels of the views from `first` up to
// `last` that see it, if three do.
inline void add_point(BundleProblem& problem, const Camera& lens, const std::vector<SE3>& poses, int first, int last,
                      const Eigen::Vector3d& place, const Eigen::Vector3d& claim, Random& random) {
  std::vector<BundleObservation> seen;
  for (int k = first; k < last; ++k) {
    const auto pixel = lens.project(poses[static_cast<size_t>(k)] * place);
    if (!pixel || pixel->x() < 0 || pixel->y() < 0 || pixel->x() >= lens.width || pixel->y() >= lens.height) continue;
    seen.push_back({.pose = k,
                    .point = static_cast<int32_t>(problem.points.size()),
                    .u = static_cast<float>(pixel->x() + kPixelNoise * random.normal()),
                    .v = static_cast<float>(pixel->y() + kPixelNoise * random.normal())});
  }
  if (seen.size() < 3) return;
  problem.points.push_back(claim);
  problem.observations.insert(problem.observations.end(), seen.begin(), seen.end());
}

// Cameras that move and turn among points, seen through a lens with some noise. Poses and points are those of a map
// that was made with a focal length of `claimed` times the true one: its depths are stretched so.
inline BundleProblem seen_through(const Camera& lens, double claimed, Motion motion, uint64_t seed,
                                  int views = kViews) {
  Random random(seed);
  BundleProblem problem;
  problem.camera = lens.pinhole;
  const Eigen::Vector3d stretch(1, 1, claimed);
  std::vector<SE3> poses;
  for (int k = 0; k < views; ++k) {
    const double s = static_cast<double>(k) / (views - 1) - 0.5;
    const bool sideways = motion == Motion::sideways;
    const Eigen::Vector3d centre = sideways ? Eigen::Vector3d(3 * s, std::sin(5 * s), 2 * s) : Eigen::Vector3d(0, 0, s);
    const Eigen::Matrix3d R = so3_exp(sideways ? Eigen::Vector3d(0.3 * std::cos(4 * s), 0.8 * s, 0.1 * s)
                                               : Eigen::Vector3d(Eigen::Vector3d::Zero()));
    poses.emplace_back(R, -(R * centre));
    problem.poses.emplace_back(R, -(R * centre.cwiseProduct(stretch)));
    problem.fixed.push_back(k == 0);
  }
  for (int p = 0; p < 600; ++p) {
    const Eigen::Vector3d place(random.uniform(-4, 4), random.uniform(-3, 3), random.uniform(4, 10));
    add_point(problem, lens, poses, 0, views, place, place.cwiseProduct(stretch), random);
  }
  return problem;
}

}  // namespace covis::lens_test
