// SPDX-License-Identifier: Apache-2.0
#include "covis/geometry/pnp.h"

#include <gtest/gtest.h>

#include <array>

#include "covis/geometry/test_geometry.h"

namespace covis {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

TEST(Pnp, MinimalSolverFindsTheTruth) {
  Random random(5);
  int found = 0;
  for (int trial = 0; trial < 300; ++trial) {
    const SE3 T_cw(so3_exp(random_vector(random, 1.5)), random_vector(random, 2));
    std::array<Vector3d, 3> points, rays;
    for (size_t k = 0; k < 3; ++k) {
      const Vector3d p_c(random.uniform(-2, 2), random.uniform(-2, 2), random.uniform(2, 8));
      points[k] = T_cw.inverse() * p_c;
      rays[k] = p_c / p_c.z();
    }
    std::array<SE3, 4> poses;
    const int count = solve_p3p(points, rays, poses);
    double best = 1e9;
    for (int k = 0; k < count; ++k) best = std::min(best, distance(poses[static_cast<size_t>(k)], T_cw));
    found += best < 1e-4;
  }
  EXPECT_GE(found, 294);
  std::array<SE3, 4> poses;
  EXPECT_EQ(solve_p3p({Vector3d(0, 0, 1), Vector3d(0, 0, 2), Vector3d(0, 0, 3)},
                      {Vector3d(0, 0, 1), Vector3d(0.1, 0, 1), Vector3d(0.2, 0, 1)}, poses),
            0);
}

// The tries that three inliers of thousands ask for are beyond an int: the search ended after the first sample.
TEST(Pnp, RansacFindsThePoseAmongThousands) {
  const Pinhole camera{500, 500, 320, 240, 0};
  Random random(7);
  const SE3 T_cw(so3_exp({0.1, 0.2, 0.3}), {1, 2, 3});
  PnpProblem problem;
  for (int i = 0; i < 6000; ++i) {
    const Vector3d p_c(random.uniform(-2, 2), random.uniform(-1.5, 1.5), random.uniform(2, 8));
    const bool wrong = i % 2 == 0;
    const Vector2d pixel = wrong ? Vector2d(random.uniform(0, 640), random.uniform(0, 480)) : camera.project(p_c);
    problem.add(T_cw.inverse() * p_c, camera.unproject(pixel.x(), pixel.y()), 1);
  }
  for (uint64_t seed = 0; seed < 20; ++seed) {
    const auto result = ransac_pnp(problem, camera, seed);
    ASSERT_TRUE(result) << seed;
    EXPECT_GE(result->inliers, 3000) << seed;
  }
}

TEST(Pnp, RansacStandsOutliers) {
  const Pinhole camera{500, 500, 320, 240, 0};
  Random random(6);
  for (int trial = 0; trial < 20; ++trial) {
    const bool planar = trial % 2;
    const SE3 T_cw(so3_exp(random_vector(random, 1)), random_vector(random, 2));
    PnpProblem problem;
    for (int i = 0; i < 100; ++i) {
      const Vector3d p_c(random.uniform(-2, 2), random.uniform(-1.5, 1.5), planar ? 4 : random.uniform(2, 8));
      const bool wrong = i % 2 == 0;
      const Vector2d pixel =
          camera.project(p_c) + (wrong ? Vector2d(random.uniform(-200, 200), random.uniform(-200, 200))
                                       : Vector2d(0.5 * random.normal(), 0.5 * random.normal()));
      problem.add(T_cw.inverse() * p_c, camera.unproject(pixel.x(), pixel.y()), 1);
    }
    const auto result = ransac_pnp(problem, camera, 17);
    ASSERT_TRUE(result);
    EXPECT_GE(result->inliers, 35);
    EXPECT_LT((result->T_cw.centre() - T_cw.centre()).norm(), 0.3);
    EXPECT_EQ(ransac_pnp(problem, camera, 17)->T_cw.t(), result->T_cw.t());
  }
  EXPECT_FALSE(ransac_pnp({}, camera, 1));
}

}  // namespace
}  // namespace covis
