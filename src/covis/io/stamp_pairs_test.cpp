// SPDX-License-Identifier: Apache-2.0
#include "covis/io/stamp_pairs.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cstdlib>
#include <map>
#include <set>
#include <tuple>

#include "covis/core/random.h"

namespace covis::io {
namespace {

using testing::ElementsAre;
using testing::Pair;

TEST(StampPairs, NearestFirstAndEachOnce) {
  constexpr Timestamp kMs = 1'000'000;
  // 0 and 1 both are near the first of the others, 1 nearer; 2 has none within 20 ms; 3 is just near enough.
  EXPECT_THAT(pair_by_stamps({1000 * kMs, 1010 * kMs, 2000 * kMs, 3000 * kMs}, {2979 * kMs, 1012 * kMs, 3020 * kMs}),
              ElementsAre(Pair(1, 1), Pair(3, 2)));
  EXPECT_THAT(pair_by_stamps({}, {1}), ElementsAre());
  EXPECT_THAT(pair_by_stamps({1}, {}), ElementsAre());
}

// The rule as it is said: of all pairs that are near enough the nearest goes first.
std::vector<std::pair<size_t, size_t>> plain_pairs(const std::vector<Timestamp>& images,
                                                   const std::vector<Timestamp>& others) {
  std::vector<std::tuple<Timestamp, size_t, Timestamp, size_t>> candidates;
  for (size_t i = 0; i < images.size(); ++i) {
    for (size_t o = 0; o < others.size(); ++o) {
      const Timestamp difference = std::abs(others[o] - images[i]);
      if (difference <= kLargestPairDifference) candidates.emplace_back(difference, i, others[o], o);
    }
  }
  std::sort(candidates.begin(), candidates.end());
  std::map<size_t, size_t> other_of;
  std::set<size_t> used;
  for (const auto& [difference, image, stamp, other] : candidates) {
    if (!other_of.contains(image) && used.insert(other).second) other_of[image] = other;
  }
  return {other_of.begin(), other_of.end()};
}

TEST(StampPairs, AreThoseOfThePlainRule) {
  Random random(5);
  for (int round = 0; round < 3000; ++round) {
    // Few steps make many equal stamps and equal differences.
    const uint32_t steps = 2 + random.below(40);
    const Timestamp step = kLargestPairDifference / (1 + random.below(6));
    const auto list = [&] {
      std::vector<Timestamp> stamps(random.below(25));
      for (Timestamp& stamp : stamps) stamp = step * random.below(steps);
      return stamps;
    };
    const std::vector<Timestamp> images = list(), others = list();
    ASSERT_EQ(pair_by_stamps(images, others), plain_pairs(images, others)) << "round " << round;
  }
}

TEST(StampPairs, TakeNoLongerWhereStampsAreEqualOrDense) {
  constexpr size_t kStamps = 200'000;  // pairs that are near enough: 40 thousand million
  std::vector<Timestamp> images(kStamps, 7), others(kStamps, 7);
  EXPECT_EQ(pair_by_stamps(images, others).size(), kStamps);
  for (size_t k = 0; k < kStamps; ++k) {
    images[k] = static_cast<Timestamp>(50 * k);
    others[k] = static_cast<Timestamp>(50 * k + 20);
  }
  const auto pairs = pair_by_stamps(images, others);
  ASSERT_EQ(pairs.size(), kStamps);
  EXPECT_TRUE(std::all_of(pairs.begin(), pairs.end(), [](const auto& pair) { return pair.first == pair.second; }));
}

}  // namespace
}  // namespace covis::io
