// SPDX-License-Identifier: Apache-2.0
#include "covis/optimization/lens_adjustment.h"

#include <gtest/gtest.h>

#include <cmath>

#include "covis/core/random.h"
#include "covis/geometry/camera.h"

namespace covis {
namespace {

constexpr int kViews = 16;
constexpr double kFocal = 500, kPixelNoise = 0.3;  // pixels

enum class Motion { sideways, ahead };

// Cameras that move and turn among points, seen through a lens with some noise. Poses and points are those of a map
// that was made with a focal length of `claimed` times the true one: its depths are stretched so.
BundleProblem seen_through(double k1, double claimed, Motion motion, uint64_t seed) {
  Camera lens{.width = 640, .height = 480, .pinhole = {kFocal, kFocal, 320, 240, 0}};
  lens.distortion = Distortion::brown_conrady;
  lens.coefficients[0] = k1;
  Random random(seed);
  BundleProblem problem;
  problem.camera = lens.pinhole;
  const Eigen::Vector3d stretch(1, 1, claimed);
  std::vector<SE3> poses;
  for (int k = 0; k < kViews; ++k) {
    const double s = static_cast<double>(k) / (kViews - 1) - 0.5;
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
    std::vector<BundleObservation> seen;
    for (int k = 0; k < kViews; ++k) {
      const auto pixel = lens.project(poses[static_cast<size_t>(k)] * place);
      if (!pixel || pixel->x() < 0 || pixel->y() < 0 || pixel->x() >= 640 || pixel->y() >= 480) continue;
      seen.push_back({.pose = k,
                      .point = static_cast<int32_t>(problem.points.size()),
                      .u = static_cast<float>(pixel->x() + kPixelNoise * random.normal()),
                      .v = static_cast<float>(pixel->y() + kPixelNoise * random.normal())});
    }
    if (seen.size() < 3) continue;
    problem.points.push_back(place.cwiseProduct(stretch));
    problem.observations.insert(problem.observations.end(), seen.begin(), seen.end());
  }
  return problem;
}

class LensAdjustmentOf : public testing::TestWithParam<std::pair<double, double>> {};

TEST_P(LensAdjustmentOf, FindsFocalLengthAndRadialCoefficientFromAfar) {
  const auto [k1, claimed] = GetParam();
  BundleProblem problem = seen_through(k1, claimed, Motion::sideways, 5);
  const LensAdjustment found = adjust_lens(problem, {claimed * kFocal, 0});
  ASSERT_TRUE(found.ok);
  const double error = found.lens.focal / kFocal - 1;
  EXPECT_LT(std::abs(error), 4 * std::max(found.sigma, found.scatter));
  EXPECT_LT(std::max(found.sigma, found.scatter), 0.005);
  EXPECT_NEAR(found.lens.k1, k1, 4 * found.k1_sigma);
  EXPECT_LT(found.k1_sigma, 0.01);
  EXPECT_NEAR(found.variance, kPixelNoise * kPixelNoise, 0.1 * kPixelNoise * kPixelNoise);
  EXPECT_GT(found.observations, problem.observations.size() * 9 / 10);
}

INSTANTIATE_TEST_SUITE_P(Lenses, LensAdjustmentOf,
                         testing::Values(std::pair{0.0, 1.0}, std::pair{0.0, 0.7}, std::pair{0.0, 1.4},
                                         std::pair{-0.15, 0.75}, std::pair{0.1, 1.3}));

TEST(LensAdjustment, TheTruthLiesWithinItsDeviationsAsOftenAsItShould) {
  int within_one = 0, within_three = 0;
  constexpr int kRuns = 20;
  for (int k = 0; k < kRuns; ++k) {
    BundleProblem problem = seen_through(-0.05, 1.05, Motion::sideways, static_cast<uint64_t>(100 + k));
    const LensAdjustment found = adjust_lens(problem, {kFocal * 1.05, 0});
    ASSERT_TRUE(found.ok);
    const double error = std::abs(found.lens.focal / kFocal - 1);
    within_one += error < found.sigma;
    within_three += error < 3 * found.sigma;
  }
  EXPECT_GE(within_one, kRuns * 45 / 100);
  EXPECT_LE(within_one, kRuns * 90 / 100);
  EXPECT_EQ(within_three, kRuns);
}

TEST(LensAdjustment, MotionStraightAheadTellsLittle) {
  BundleProblem ahead = seen_through(0, 1, Motion::ahead, 5), sideways = seen_through(0, 1, Motion::sideways, 5);
  const LensAdjustment little = adjust_lens(ahead, {kFocal, 0}), much = adjust_lens(sideways, {kFocal, 0});
  ASSERT_TRUE(much.ok);
  EXPECT_TRUE(!little.ok || std::max(little.sigma, little.scatter) > 5 * std::max(much.sigma, much.scatter));
}

TEST(LensAdjustment, KeepsTheCoefficientWhenAskedTo) {
  BundleProblem problem = seen_through(-0.1, 1, Motion::sideways, 5);
  const LensAdjustment found = adjust_lens(problem, {kFocal, 0}, {.usual_k1 = 0});
  ASSERT_TRUE(found.ok);
  EXPECT_NEAR(found.lens.k1, 0, 1e-6);
  EXPECT_GT(std::abs(found.lens.focal / kFocal - 1), 0.01) << "the focal length makes up for it";
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
  const std::atomic<bool> interrupt = true;
  EXPECT_FALSE(adjust_lens(problem, {kFocal, 0}, {.interrupt = &interrupt}).ok);
}

}  // namespace
}  // namespace covis
