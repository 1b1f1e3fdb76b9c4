// SPDX-License-Identifier: Apache-2.0
// For the tests of optimization: a camera, poses drawn at random, bundle problems with known truth.
#pragma once

#include <cmath>
#include <vector>

#include "covis/core/random.h"
#include "covis/optimization/bundle_adjustment.h"

namespace covis {

inline const Pinhole kCamera{500, 510, 320, 240, 40};

inline SE3 random_pose(Random& random, double angle, double distance) {
  Vector6d xi;
  for (int k = 0; k < 3; ++k) {
    xi(k) = random.uniform(-distance, distance);
    xi(k + 3) = random.uniform(-angle, angle);
  }
  return SE3::exp(xi);
}

struct World {
  BundleProblem problem;
  std::vector<SE3> true_poses;
};

enum class Rows { mono, stereo, mixed };

// Cameras on an arc before a cloud of points, noise of a pixel, start values off the truth.
inline World make_world(uint64_t seed, int poses, int points, Rows rows, double outliers, bool loop = false) {
  Random random(seed);
  World world;
  BundleProblem& problem = world.problem;
  problem.camera = kCamera;
  for (int c = 0; c < poses; ++c) {
    const double s = static_cast<double>(c) / poses;
    const SE3 base = loop ? SE3(so3_exp({0, 6.283 * s, 0}), Eigen::Vector3d(0, 0, 4))
                          : SE3(so3_exp({0, 0.5 * (s - 0.5), 0}), Eigen::Vector3d(1.5 - 3 * s, 0.1 * s, 0));
    world.true_poses.push_back(random_pose(random, 0.02, 0.05) * base);
    problem.fixed.push_back(c < 2);
    problem.poses.push_back(c < 2 ? world.true_poses.back()
                                  : random_pose(random, 0.01, 0.03) * world.true_poses.back());
  }
  for (int p = 0; p < points; ++p) {
    Eigen::Vector3d at;
    if (loop) {
      const double angle = random.uniform(0, 6.283), r = random.uniform(8, 12);
      at = {r * std::sin(angle), random.uniform(-2, 2), r * std::cos(angle)};
    } else {
      at = {random.uniform(-4, 4), random.uniform(-3, 3), random.uniform(5, 12)};
    }
    std::vector<BundleObservation> seen;
    for (int c = 0; c < poses; ++c) {
      const Eigen::Vector3d p_c = world.true_poses[static_cast<size_t>(c)] * at;
      if (p_c.z() < 1) continue;
      const Eigen::Vector2d pixel = kCamera.project(p_c);
      if (pixel.x() < 0 || pixel.x() > 640 || pixel.y() < 0 || pixel.y() > 480) continue;
      BundleObservation o;
      o.pose = c;
      o.point = static_cast<int32_t>(problem.points.size());
      const bool wrong = random.uniform() < outliers;
      o.u = static_cast<float>(pixel.x() + random.normal() + (wrong ? 30 : 0));
      o.v = static_cast<float>(pixel.y() + random.normal());
      const bool stereo = rows == Rows::stereo || (rows == Rows::mixed && p % 2);
      const double right = pixel.x() - kCamera.bf / p_c.z() + random.normal(), disparity = o.u - right;
      o.inv_sigma2 = static_cast<float>(1 / std::pow(1.44, random.below(4)));
      if (stereo && disparity > 0) o.disparity = {static_cast<float>(disparity), o.inv_sigma2};
      seen.push_back(o);
    }
    if (seen.size() < 3) continue;
    problem.observations.insert(problem.observations.end(), seen.begin(), seen.end());
    problem.points.push_back(
        at + Eigen::Vector3d(random.uniform(-0.1, 0.1), random.uniform(-0.1, 0.1), random.uniform(-0.1, 0.1)));
  }
  return world;
}

}  // namespace covis
