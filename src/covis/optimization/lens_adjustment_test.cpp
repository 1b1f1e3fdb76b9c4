// SPDX-License-Identifier: Apache-2.0
#include "covis/optimization/lens_adjustment.h"

#include <gtest/gtest.h>

#include <cmath>

#include "covis/core/random.h"
#include "covis/geometry/camera.h"
#include "covis/optimization/test_lens_problem.h"

namespace covis {
namespace {

using lens_test::camera_with;
using lens_test::kFocal;
using lens_test::kPixelNoise;
using lens_test::Motion;
using lens_test::seen_through;

BundleProblem seen_through(double k1, double claimed, Motion motion, uint64_t seed) {
  return seen_through(camera_with({kFocal, k1}), claimed, motion, seed);
}

struct LensCase {
  double k1, k2, claimed;
};

class LensAdjustmentOf : public testing::TestWithParam<LensCase> {};

TEST_P(LensAdjustmentOf, FindsFocalLengthAndRadialCoefficientsFromAfar) {
  const auto [k1, k2, claimed] = GetParam();
  BundleProblem problem = seen_through(camera_with({kFocal, k1, k2}), claimed, Motion::sideways, 5);
  const LensAdjustment found = adjust_lens(problem, {claimed * kFocal, 0});
  ASSERT_TRUE(found.ok);
  const double error = found.lens.focal / kFocal - 1;
  EXPECT_LT(std::abs(error), 4 * found.deviation().focal);
  EXPECT_LT(found.deviation().focal, 0.005);
  EXPECT_NEAR(found.lens.k1, k1, 4 * found.deviation().k1);
  EXPECT_LT(found.deviation().k1, 0.01);
  EXPECT_NEAR(found.lens.k2, k2, 4 * found.deviation().k2);
  EXPECT_LT(found.deviation().k2, 0.02);
  EXPECT_NEAR(found.variance, kPixelNoise * kPixelNoise, 0.1 * kPixelNoise * kPixelNoise);
  EXPECT_GT(found.observations, problem.observations.size() * 9 / 10);
}

INSTANTIATE_TEST_SUITE_P(Lenses, LensAdjustmentOf,
                         testing::Values(LensCase{0, 0, 1}, LensCase{0, 0, 0.7}, LensCase{0, 0, 1.4},
                                         LensCase{-0.15, 0, 0.75}, LensCase{0.1, 0, 1.3}, LensCase{-0.26, 0.08, 0.8},
                                         LensCase{-0.1, -0.1, 1.2}));

TEST(LensAdjustmentLong, TheTruthLiesWithinItsDeviationsAsOftenAsItShould) {
  int within_one = 0, within_three = 0;
  constexpr int kRuns = 20;
  for (int k = 0; k < kRuns; ++k) {
    BundleProblem problem = seen_through(-0.05, 1.05, Motion::sideways, static_cast<uint64_t>(100 + k));
    const LensAdjustment found = adjust_lens(problem, {kFocal * 1.05, 0});
    ASSERT_TRUE(found.ok);
    const double error = std::abs(found.lens.focal / kFocal - 1);
    within_one += error < found.sigma.focal;
    within_three += error < 3 * found.sigma.focal;
  }
  EXPECT_GE(within_one, kRuns * 45 / 100);
  EXPECT_LE(within_one, kRuns * 90 / 100);
  EXPECT_EQ(within_three, kRuns);
}

constexpr double kNarrow = 772;  // pixels: 45 degrees

// A camera of 45 degrees goes along a road that bends, as a map shows it that was made with a focal length of `claimed`
// times the true one: it turns less or more, its way and all depths are stretched or shortened.
BundleProblem along_a_bend(double claimed) {
  constexpr double kStep = 0.8, kTurn = 0.03;
  constexpr int kAlong = 110, kSeen = 12;
  const Camera camera = camera_with({kNarrow});
  const auto poses = [&](double stretch) {
    std::vector<SE3> made;
    Eigen::Vector3d centre = Eigen::Vector3d::Zero();
    double heading = 0;
    for (int k = 0; k < kAlong; ++k) {
      const Eigen::Matrix3d R = so3_exp({0, -heading, 0});
      made.emplace_back(R, -(R * centre));
      if (k % 20 >= 10) heading += kTurn / stretch;
      centre += R.transpose() * Eigen::Vector3d(0, 0.02 * std::sin(k), kStep * stretch);
    }
    return made;
  };
  const std::vector<SE3> truth = poses(1), claims = poses(claimed);
  BundleProblem problem;
  problem.camera = camera.pinhole;
  problem.poses = claims;
  problem.fixed.assign(claims.size(), 0);
  Random random(3);
  for (int from = 0; from < kAlong; ++from) {
    const auto k = static_cast<size_t>(from);
    for (int p = 0; p < 25; ++p) {
      const double depth = random.uniform(6, 25);
      const Eigen::Vector2d ray(random.uniform(-0.4, 0.4), random.uniform(-0.3, 0.3));
      const Eigen::Vector3d seen = depth * ray.homogeneous(), claim(seen.x(), seen.y(), claimed * depth);
      lens_test::add_point(problem, camera, truth, from, std::min(from + kSeen, kAlong), truth[k].inverse() * seen,
                           claims[k].inverse() * claim, random);
    }
  }
  return problem;
}

// A change of the focal length bends the whole path: where the cost may never rise, 60 steps end 30 pixels off.
TEST(LensAdjustment, GoesTheWholeWayWhereALongPathBends) {
  for (const double claimed : {0.9, 1.1}) {
    BundleProblem problem = along_a_bend(claimed);
    const LensAdjustment found = adjust_lens(problem, {claimed * kNarrow}, {.usual = {}});
    ASSERT_TRUE(found.ok);
    EXPECT_LT(std::abs(found.lens.focal / kNarrow - 1), 3 * found.sigma.focal) << claimed;
    EXPECT_LT(found.sigma.focal, 0.004);
  }
}

TEST(LensAdjustmentLong, MotionStraightAheadTellsLittle) {
  BundleProblem ahead = seen_through(0, 1, Motion::ahead, 5), sideways = seen_through(0, 1, Motion::sideways, 5);
  const LensAdjustment little = adjust_lens(ahead, {kFocal, 0}), much = adjust_lens(sideways, {kFocal, 0});
  ASSERT_TRUE(much.ok);
  EXPECT_TRUE(!little.ok || little.deviation().focal > 5 * much.deviation().focal);
}

TEST(LensAdjustment, KeepsTheCoefficientsWhenAskedTo) {
  BundleProblem problem = seen_through(-0.1, 1, Motion::sideways, 5);
  const LensAdjustment found = adjust_lens(problem, {kFocal, 0}, {.usual = {}});
  ASSERT_TRUE(found.ok);
  EXPECT_NEAR(found.lens.k1, 0, 1e-6);
  EXPECT_NEAR(found.lens.k2, 0, 1e-6);
  EXPECT_GT(std::abs(found.lens.focal / kFocal - 1), 0.01) << "the focal length makes up for it";
}

TEST(LensAdjustment, FindsThePrincipalPointWhenAskedTo) {
  Camera lens = camera_with({kFocal, -0.1});
  BundleProblem problem = seen_through(lens, 1.1, Motion::sideways, 5);
  problem.camera.cx += 9;
  problem.camera.cy -= 6;
  const LensOptions free{.usual = {.k1 = 0.3, .k2 = 0.1, .cx = 10, .cy = 10}};
  const LensAdjustment found = adjust_lens(problem, {1.1 * kFocal}, free);
  ASSERT_TRUE(found.ok);
  EXPECT_NEAR(found.lens.cx, -9, 4 * found.deviation().cx);
  EXPECT_NEAR(found.lens.cy, 6, 4 * found.deviation().cy);
  EXPECT_LT(std::max(found.deviation().cx, found.deviation().cy), 1);
  EXPECT_NEAR(found.lens.focal, kFocal, 4 * found.deviation().focal * kFocal);
}

// Straight ahead nothing tells the principal point from the direction that the camera goes in.
TEST(LensAdjustment, WhatNothingTellsIsAsUncertainAsBefore) {
  BundleProblem problem = seen_through(0, 1, Motion::ahead, 5);
  for (BundleObservation& o : problem.observations) o.inv_sigma2 = 100;  // weights are relative
  const LensAdjustment found = adjust_lens(problem, {kFocal}, {.usual = {.cx = 10, .cy = 10}});
  ASSERT_TRUE(found.ok);
  EXPECT_NEAR(found.deviation().cx, 10, 2);
  EXPECT_NEAR(found.deviation().cy, 10, 2);
}

TEST(LensAdjustment, WhatIsNotOkLeavesTheProblem) {
  BundleProblem problem = seen_through(0, 1.2, Motion::sideways, 5);
  const Eigen::Vector3d point = problem.points.front();
  EXPECT_FALSE(adjust_lens(problem, {kFocal}, {.interrupted = [] { return true; }}).ok);
  EXPECT_EQ(problem.points.front(), point);
}

TEST(LensAdjustment, WrongMatchesDoNoHarm) {
  BundleProblem problem = seen_through(-0.05, 0.9, Motion::sideways, 5);
  for (size_t k = 0; k < problem.observations.size(); k += 20) problem.observations[k].u += 40;
  const LensAdjustment found = adjust_lens(problem, {0.9 * kFocal, 0});
  ASSERT_TRUE(found.ok);
  EXPECT_NEAR(found.lens.focal, kFocal, 0.01 * kFocal);
  EXPECT_LT(found.observations, problem.observations.size() * 96 / 100);
}

TEST(LensAdjustment, WhatHasNothingToSolveOrIsInterruptedIsNotOk) {
  BundleProblem empty;
  EXPECT_FALSE(adjust_lens(empty, {kFocal, 0}).ok);
  BundleProblem problem = seen_through(0, 1, Motion::sideways, 5);
  EXPECT_FALSE(adjust_lens(problem, {kFocal, 0}, {.interrupted = [] { return true; }}).ok);
}

}  // namespace
}  // namespace covis
