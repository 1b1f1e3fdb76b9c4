// SPDX-License-Identifier: Apache-2.0
#include "covis/core/quantile.h"

#include <gtest/gtest.h>

#include <vector>

namespace covis {
namespace {

TEST(Quantile, IsTheValueOfTheNearestRank) {
  const std::vector<double> values{4, 1, 3, 2};
  EXPECT_EQ(quantile(values, 0), 1);
  EXPECT_EQ(quantile(values, 0.49), 2);
  EXPECT_EQ(quantile(values, 0.51), 3);
  EXPECT_EQ(quantile(values, 0.5), 3) << "the upper median";
  EXPECT_EQ(quantile({5, 9, 7}, 0.5), 7);
  EXPECT_EQ(quantile(values, 1), 4);
  EXPECT_EQ(quantile({7}, 0.95), 7);
  EXPECT_EQ(quantile({}, 0.5), 0);
}

}  // namespace
}  // namespace covis
