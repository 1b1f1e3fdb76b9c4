// SPDX-License-Identifier: Apache-2.0
#include "covis/optimization/columns_estimation.h"

#include <gtest/gtest.h>

#include <cmath>

#include "covis/optimization/test_pair_problem.h"

namespace covis {
namespace {

using pair_test::pair_problem;

std::optional<ColumnsEstimate> columns_of(BundleProblem problem) {
  BundleAdjuster adjuster;
  adjuster.solve(problem, {.iterations = 30});
  classify_observations(problem);
  return estimate_columns(problem, adjuster);
}

TEST(Columns, AreFoundFromMotion) {
  const ShiftField truth{{0.05, 0.6, -0.3, 0.2, 1.1, -4, -1.5}};
  for (const uint64_t seed : {1, 2, 3}) {
    const auto found = columns_of(pair_problem(truth, seed));
    ASSERT_TRUE(found);
    double most = 0;
    for (const double x : {-0.5, 0.0, 0.5})
      for (const double y : {-0.3, 0.0, 0.3}) most = std::max(most, std::abs(found->field.at(x, y) - truth.at(x, y)));
    EXPECT_LT(most, 0.15) << seed;
    EXPECT_GT(found->size, 5 * found->noise) << seed;
  }
}

// The standard deviation is about right.
TEST(Columns, NoneAreFoundWhereNoneAreOff) {
  double sum = 0;
  constexpr int kSeeds = 6;
  for (uint64_t seed = 1; seed <= kSeeds; ++seed) {
    const auto found = columns_of(pair_problem({}, seed));
    ASSERT_TRUE(found);
    EXPECT_LT(found->size, 3 * found->noise) << seed;
    sum += found->size / found->noise / kSeeds;
  }
  EXPECT_GT(sum, 0.3);
  EXPECT_LT(sum, 1.7);
}

TEST(Columns, AreNotToldByPointsWithoutDisparity) {
  BundleProblem problem = pair_problem({}, 1);
  for (BundleObservation& o : problem.observations) o.disparity = {};
  EXPECT_FALSE(columns_of(problem));
}

TEST(Columns, AnInterruptEndsIt) {
  BundleAdjuster adjuster;
  const std::atomic<bool> interrupt{true};
  EXPECT_FALSE(estimate_columns(pair_problem({}, 1), adjuster, &interrupt));
}

TEST(Columns, TakenOutTheDisparitiesAreThoseOfARectifiedPair) {
  const ShiftField truth{{0.3, 0.6}};
  BundleProblem problem = pair_problem(truth, 1), rectified = pair_problem({}, 1);
  ASSERT_TRUE(take_out(truth, problem));
  EXPECT_EQ(problem.camera.right_columns, truth);
  for (size_t k = 0; k < problem.observations.size(); ++k)
    EXPECT_NEAR(problem.observations[k].disparity.pixels, rectified.observations[k].disparity.pixels, 2e-3);
  EXPECT_FALSE(take_out(ShiftField{{9}}, problem)) << "no rectification leaves that";
  EXPECT_EQ(problem.camera.right_columns, truth);
}

}  // namespace
}  // namespace covis
