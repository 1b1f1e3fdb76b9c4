// SPDX-License-Identifier: Apache-2.0
// The two ways to solve the reduced system: dense for few poses, by blocks for many.
#include <gtest/gtest.h>

#include "tests/ceres_problems.h"

namespace covis {
namespace {

// More poses than the dense solver takes.
World make_sparse_world(uint64_t seed) {
  World world = make_world(seed, 70, 150, Rows::mixed, 0, true);
  for (int k = 0; k < 20; ++k) {  // seen twice by one camera
    BundleObservation twice = world.problem.observations[static_cast<size_t>(k) * 7];
    twice.u += 0.5f;
    world.problem.observations.push_back(twice);
  }
  return world;
}

TEST(BundleAdjustment, SparseLoopEndsWhereCeresEnds) {
  World world = make_sparse_world(8);
  const double theirs = ceres_cost(world.problem, true);
  const BundleSummary summary =
      BundleAdjuster().solve(world.problem, {.iterations = 100, .relative_cost_change = 1e-12});
  EXPECT_NEAR(summary.final_cost, theirs, 1e-6 * theirs);
  for (const size_t c : {0, 1}) EXPECT_EQ(world.problem.poses[c].t(), world.true_poses[c].t());
}

TEST(BundleAdjustment, SparseAndDenseProblemsTakeTurnsWithTheSameBits) {
  BundleAdjuster adjuster;
  World dense_first = make_world(13, 10, 100, Rows::mixed, 0.05), sparse_first = make_sparse_world(14);
  World dense_again = dense_first, sparse_again = sparse_first;
  for (World* world : {&sparse_first, &dense_first, &sparse_again, &dense_again}) {
    // A point that comes behind cameras that should see it.
    world->problem.points[5] = -3 * world->problem.points[5];
    EXPECT_TRUE(adjuster.solve(world->problem, {.iterations = 5}).ok);
  }
  EXPECT_EQ(sparse_first.problem.points, sparse_again.problem.points);
  EXPECT_EQ(dense_first.problem.points, dense_again.problem.points);
  for (size_t c = 0; c < sparse_first.problem.poses.size(); ++c) {
    EXPECT_EQ(sparse_first.problem.poses[c].t(), sparse_again.problem.poses[c].t());
    EXPECT_EQ(sparse_first.problem.poses[c].R(), sparse_again.problem.poses[c].R());
  }
}

}  // namespace
}  // namespace covis
