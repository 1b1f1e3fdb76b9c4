// SPDX-License-Identifier: Apache-2.0
#include "covis/optimization/bundle_adjustment.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <limits>
#include <utility>
#include <vector>

#include "tests/ceres_problems.h"

namespace covis {
namespace {

TEST(BundleAdjustment, EndsWhereCeresEnds) {
  BundleAdjuster adjuster;
  for (const Rows rows : {Rows::mono, Rows::stereo, Rows::mixed}) {
    for (const bool robust : {true, false}) {
      World world = make_world(7, 10, 200, rows, robust ? 0.1 : 0);
      const double theirs = ceres_cost(world.problem, robust);
      const BundleSummary summary =
          adjuster.solve(world.problem, {.iterations = 100, .robust = robust, .relative_cost_change = 1e-12});
      EXPECT_TRUE(summary.ok);
      EXPECT_NEAR(summary.final_cost, theirs, 1e-6 * theirs) << static_cast<int>(rows) << robust;
      EXPECT_LT(summary.final_cost, summary.initial_cost);
    }
  }
}

TEST(BundleAdjustment, ClassifiesOutliers) {
  World world = make_world(9, 8, 200, Rows::stereo, 0.1);
  BundleAdjuster().solve(world.problem, {.iterations = 30});
  const int inactive = classify_observations(world.problem);
  const auto all = static_cast<double>(world.problem.observations.size());
  EXPECT_GT(inactive, 0.08 * all);
  EXPECT_LT(inactive, 0.25 * all);
}

TEST(BundleAdjustment, InterruptionLeavesAValidState) {
  World world = make_world(10, 10, 300, Rows::mixed, 0);
  const World before = world;
  const std::atomic<bool> stop{true};
  const BundleSummary summary = BundleAdjuster().solve(world.problem, {.iterations = 50, .interrupt = &stop});
  EXPECT_TRUE(summary.interrupted);
  EXPECT_LE(summary.final_cost, summary.initial_cost);
  for (const SE3& pose : world.problem.poses) EXPECT_TRUE(pose.all_finite());
}

TEST(BundleAdjustment, WhatIsNotFiniteIsNotSolved) {
  World world = make_world(10, 10, 300, Rows::mixed, 0);
  world.problem.observations[7].u = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(BundleAdjuster().solve(world.problem, {.iterations = 10}).ok);
}

// The median of the ratios of the points' distances from the first pose.
double growth_of(const BundleProblem& after, const BundleProblem& before) {
  std::vector<double> ratios;
  for (size_t p = 0; p < after.points.size(); ++p) {
    const Eigen::Vector3d centre = after.poses[0].centre();
    ratios.push_back((after.points[p] - centre).norm() / (before.points[p] - centre).norm());
  }
  std::sort(ratios.begin(), ratios.end());
  return ratios[ratios.size() / 2];
}

TEST(BundleAdjustment, AScaleThatNothingTellsStays) {
  BundleAdjuster adjuster;
  World world = make_world(13, 10, 200, Rows::mono, 0);
  std::fill(world.problem.fixed.begin() + 1, world.problem.fixed.end(), 0);
  const BundleProblem before = world.problem;
  const BundleSummary summary = adjuster.solve(world.problem, {.iterations = 30});
  EXPECT_LT(summary.final_cost, 0.5 * summary.initial_cost);
  EXPECT_NEAR(growth_of(world.problem, before), 1, 0.001);
  EXPECT_EQ(world.problem.poses[0].t(), before.poses[0].t());
  const BundleSummary after = adjuster.solve(world.problem, {.iterations = 0});
  EXPECT_NEAR(after.initial_cost, summary.final_cost, 1e-6 * summary.final_cost) << "points are scaled with the poses";
}

// One view of it leaves a point undetermined; it stays where it was, though the others shrink and are scaled back.
TEST(BundleAdjustment, APointThatDoesNotMoveIsNotScaled) {
  World world = make_world(13, 10, 200, Rows::mono, 0);
  std::fill(world.problem.fixed.begin() + 1, world.problem.fixed.end(), 0);
  bool first = true;
  for (BundleObservation& o : world.problem.observations) {
    if (o.point == 5) o.active = std::exchange(first, false);
  }
  const Eigen::Vector3d before = world.problem.points[5], other = world.problem.points[6];
  BundleAdjuster().solve(world.problem, {.iterations = 30});
  EXPECT_EQ(world.problem.points[5], before);
  EXPECT_NE(world.problem.points[6], other);
}

TEST(BundleAdjustment, AScaleThatDepthTellsIsFound) {
  World world = make_world(14, 10, 200, Rows::stereo, 0);
  BundleProblem& problem = world.problem;
  std::fill(problem.fixed.begin() + 1, problem.fixed.end(), 0);
  BundleAdjuster().solve(problem, {.iterations = 60});
  const BundleProblem right = problem;
  const Eigen::Vector3d centre = problem.poses[0].centre();
  for (SE3& T_cw : problem.poses)
    T_cw = SE3(T_cw.R(), Eigen::Vector3d(-(T_cw.R() * (centre + 0.7 * (T_cw.centre() - centre)))));
  for (Eigen::Vector3d& point : problem.points) point = centre + 0.7 * (point - centre);
  BundleAdjuster().solve(problem, {.iterations = 60});
  EXPECT_NEAR(growth_of(problem, right), 1, 0.01);
}

TEST(BundleAdjustment, DegenerateProblemsEndWell) {
  BundleAdjuster adjuster;
  BundleProblem empty;
  empty.camera = kCamera;
  EXPECT_FALSE(adjuster.solve(empty, {}).ok);
  World world = make_world(11, 6, 60, Rows::mono, 0);
  for (auto& fixed : world.problem.fixed) fixed = 0;  // a free gauge
  world.problem.poses.push_back(SE3());               // a pose nobody observes from
  world.problem.fixed.push_back(0);
  world.problem.points.emplace_back(0, 0, 6);  // a point seen once
  BundleObservation once;
  once.point = static_cast<int32_t>(world.problem.points.size()) - 1;
  once.u = 320;
  once.v = 240;
  world.problem.observations.push_back(once);
  const BundleSummary summary = adjuster.solve(world.problem, {.iterations = 30});
  EXPECT_LT(summary.final_cost, summary.initial_cost);
  for (const SE3& pose : world.problem.poses) EXPECT_TRUE(pose.all_finite());
  for (const auto& point : world.problem.points) EXPECT_TRUE(point.allFinite());
}

TEST(BundleAdjustment, TwoRunsGiveTheSameBits) {
  World a = make_world(12, 12, 300, Rows::mixed, 0.05), b = a;
  BundleAdjuster adjuster;
  adjuster.solve(a.problem, {.iterations = 8});
  adjuster.solve(b.problem, {.iterations = 8});
  for (size_t c = 0; c < a.problem.poses.size(); ++c) {
    EXPECT_EQ(a.problem.poses[c].t(), b.problem.poses[c].t());
    EXPECT_EQ(a.problem.poses[c].R(), b.problem.poses[c].R());
  }
  EXPECT_EQ(a.problem.points, b.problem.points);
}

}  // namespace
}  // namespace covis
