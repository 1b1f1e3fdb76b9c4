// SPDX-License-Identifier: Apache-2.0
#include "covis/optimization/depth_noise_estimation.h"

#include <gtest/gtest.h>

#include "covis/optimization/test_problems.h"

namespace covis {
namespace {

// Points seen by five cameras, with depths that are `factor` times as noisy as the model says, and `wrong` of them far
// off. The problem is at the truth.
BundleProblem problem_with_noise(double factor, double wrong) {
  Random random(5);
  BundleProblem problem;
  problem.camera = kCamera;
  problem.camera.depth_noise = DepthNoise::kinect();
  for (int c = 0; c < 5; ++c) {
    problem.poses.emplace_back(Eigen::Matrix3d::Identity(), Eigen::Vector3d(-0.1 * c, 0, 0));
    problem.fixed.push_back(c == 0);
  }
  for (int p = 0; p < 300; ++p) {
    problem.points.emplace_back(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(2, 5));
    for (int c = 0; c < 5; ++c) {
      const Eigen::Vector3d p_c = problem.poses[static_cast<size_t>(c)] * problem.points.back();
      const Eigen::Vector2d pixel = kCamera.project(p_c);
      double z = p_c.z() + factor * problem.camera.depth_noise.sigma(p_c.z()) * random.normal();
      if (random.uniform() < wrong) z *= 1.3;
      problem.observations.push_back({.pose = c,
                                      .point = p,
                                      .u = static_cast<float>(pixel.x()),
                                      .v = static_cast<float>(pixel.y()),
                                      .inv_sigma2 = 100,
                                      .disparity = disparity_of_depth(problem.camera, static_cast<float>(z), 100)});
    }
  }
  return problem;
}

TEST(DepthNoiseEstimation, FindsTheFactor) {
  for (const double factor : {0.3, 1.0, 3.0}) {
    const auto found = depth_noise_factor(problem_with_noise(factor, 0));
    ASSERT_TRUE(found);
    // Points at the truth have whole errors; the share of a point's own depths is one for adjusted points.
    EXPECT_NEAR(*found, factor * std::sqrt(5.0 / 4), 0.12 * factor);
    EXPECT_NEAR(*depth_noise_factor(problem_with_noise(factor, 0.1)), *found, 0.25 * factor) << "with wrong depths";
  }
}

TEST(DepthNoiseEstimation, SaysNothingOfOtherSensorsAndFewDepths) {
  BundleProblem problem = problem_with_noise(1, 0);
  problem.camera.depth_noise = {};
  EXPECT_FALSE(depth_noise_factor(problem));
  problem = problem_with_noise(1, 0);
  problem.observations.resize(90);
  EXPECT_FALSE(depth_noise_factor(problem));
}

}  // namespace
}  // namespace covis
