// SPDX-License-Identifier: Apache-2.0
#include "covis/tracking/usual_interval.h"

#include <gtest/gtest.h>

#include <vector>

namespace covis {
namespace {

// Which of the intervals, in milliseconds, are bursts.
std::vector<size_t> bursts(const std::vector<int>& milliseconds) {
  UsualInterval usual;
  std::vector<size_t> found;
  for (size_t k = 0; k < milliseconds.size(); ++k) {
    if (usual.is_burst(milliseconds[k] * 1'000'000LL)) found.push_back(k);
  }
  return found;
}

using Found = std::vector<size_t>;

TEST(UsualInterval, AFrameMuchSoonerThanUsualIsABurst) {
  EXPECT_EQ(bursts({33, 33, 33, 33, 3, 63, 33, 33, 3, 63}), Found({4, 8}));
  EXPECT_EQ(bursts({33, 33, 33, 33, -3, -63}), Found({4})) << "frames are followed backward";
}

TEST(UsualInterval, FramesLeftOutAndSmallJitterAreNone) {
  EXPECT_EQ(bursts({33, 33, 33, 200, 33, 33, 400, 33, 33, 33, 67, 33}), Found());
  EXPECT_EQ(bursts({33, 67, 33, 67, 33, 67, 33, 67}), Found());
  EXPECT_EQ(bursts({33, 24, 42, 33, 33, 24, 42}), Found());
  EXPECT_EQ(bursts({1000, 33, 33, 33, 33, 33, 33}), Found()) << "the first one says nothing of the others";
}

TEST(UsualInterval, EverySecondOneIsABurstWhereFramesComeInPairs) {
  EXPECT_EQ(bursts({3, 63, 3, 63, 3, 63, 3, 63}), Found({4, 6}));
}

TEST(UsualInterval, AnotherRateIsUsualSoon) {
  const Found found = bursts({100, 100, 100, 100, 100, 100, 100, 100, 33, 33, 33, 33, 33, 33, 33, 33, 33, 33});
  ASSERT_FALSE(found.empty());
  EXPECT_EQ(found.front(), 8u);
  EXPECT_LE(found.back(), 8u + 5u);
}

}  // namespace
}  // namespace covis
