// SPDX-License-Identifier: Apache-2.0
#include "covis/io/stamp_pairs.h"

#include <gmock/gmock.h>

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

}  // namespace
}  // namespace covis::io
