// SPDX-License-Identifier: Apache-2.0
#include "covis/core/stamp_bounds.h"

#include <gtest/gtest.h>

#include <limits>

namespace covis {
namespace {

TEST(StampBounds, DifferencesFitWithinThem) {
  constexpr Timestamp kLast = kStampBound - 1;
  EXPECT_TRUE(is_usable_stamp(kLast) && is_usable_stamp(-kLast) && is_usable_stamp(0));
  EXPECT_TRUE(is_usable_stamp(1'800'000'000'000'000'000)) << "nanoseconds of these years";
  EXPECT_FALSE(is_usable_stamp(kStampBound) || is_usable_stamp(-kStampBound));
  EXPECT_FALSE(is_usable_stamp(std::numeric_limits<Timestamp>::min()));
  EXPECT_LE(kLast, std::numeric_limits<Timestamp>::max() - kLast);
}

}  // namespace
}  // namespace covis
