// SPDX-License-Identifier: Apache-2.0
#include "covis/geometry/clearly_least.h"

#include <gtest/gtest.h>

#include <array>

namespace covis {
namespace {

TEST(ClearlyLeast, EveryOtherExceedsItByFactorAndDifference) {
  EXPECT_EQ(clearly_least(std::array{90.0, 30.0, 80.0}, 2, 40), 1u);
  EXPECT_EQ(clearly_least(std::array{90.0, 30.0, 80.0}, 2.8, 40), std::nullopt) << "80 is less than 2.8 times as great";
  EXPECT_EQ(clearly_least(std::array{90.0, 30.0, 80.0}, 2, 51), std::nullopt) << "80 is greater by 50";
  EXPECT_EQ(clearly_least(std::array{0.0, 0.0}, 2, 1), std::nullopt);
  EXPECT_EQ(clearly_least(std::array{7.0}, 2, 1), 0u);
  EXPECT_EQ(clearly_least({}, 2, 1), std::nullopt);
}

}  // namespace
}  // namespace covis
