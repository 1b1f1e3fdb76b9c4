// SPDX-License-Identifier: Apache-2.0
#include "covis/core/random.h"

#include <gmock/gmock.h>

#include <array>
#include <set>

namespace covis {
namespace {

TEST(Random, GivesSplitMix64sPublishedNumbers) {
  Random random(1234567);
  for (const uint64_t expected : {6457827717110365317ull, 3203168211198807973ull, 9817491932198370423ull,
                                  4593380528125082431ull, 16408922859458223821ull})
    EXPECT_EQ(random.next(), expected);
}

TEST(Random, BelowReachesEveryNumberEquallyOften) {
  Random random(1);
  std::array<int, 7> count{};
  for (int i = 0; i < 70'000; ++i) {
    const uint32_t value = random.below(7);
    ASSERT_LT(value, 7u);
    ++count[value];
  }
  for (const int n : count) EXPECT_NEAR(n, 10'000, 400);  // four standard deviations
  for (int i = 0; i < 100; ++i) EXPECT_EQ(random.below(1), 0u);
}

TEST(Random, UniformFillsItsInterval) {
  Random random(2);
  double least = 1, greatest = 0, sum = 0;
  for (int i = 0; i < 100'000; ++i) {
    const double value = random.uniform();
    ASSERT_GE(value, 0);
    ASSERT_LT(value, 1);
    least = std::min(least, value);
    greatest = std::max(greatest, value);
    sum += value;
  }
  EXPECT_LT(least, 1e-3);
  EXPECT_GT(greatest, 1 - 1e-3);
  EXPECT_NEAR(sum / 100'000, 0.5, 0.004);
  for (int i = 0; i < 1000; ++i) {
    const double value = random.uniform(-3, 5);
    ASSERT_GE(value, -3);
    ASSERT_LT(value, 5);
  }
}

TEST(Random, NormalHasMeanZeroAndDeviationOne) {
  Random random(3);
  double sum = 0, squares = 0;
  int beyond_two = 0;
  constexpr int kCount = 100'000;
  for (int i = 0; i < kCount; ++i) {
    const double value = random.normal();
    ASSERT_TRUE(std::isfinite(value));
    sum += value;
    squares += value * value;
    beyond_two += std::abs(value) > 2;
  }
  EXPECT_NEAR(sum / kCount, 0, 0.013);
  EXPECT_NEAR(squares / kCount, 1, 0.02);
  EXPECT_NEAR(beyond_two / double{kCount}, 0.0455, 0.003);
}

TEST(Random, SeedsOfStagesAndFramesDiffer) {
  static_assert(hash_seed(1, 2, 3) == hash_seed(1, 2, 3));
  std::set<uint64_t> seeds;
  for (uint64_t seed = 0; seed < 10; ++seed) {
    for (uint64_t stage = 0; stage < 10; ++stage) {
      for (uint64_t frame = 0; frame < 10; ++frame) seeds.insert(hash_seed(seed, stage, frame));
    }
  }
  EXPECT_EQ(seeds.size(), 1000u);
}

}  // namespace
}  // namespace covis
