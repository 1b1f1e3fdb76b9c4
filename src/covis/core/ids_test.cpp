// SPDX-License-Identifier: Apache-2.0
#include "covis/core/ids.h"

#include <gtest/gtest.h>

#include <type_traits>
#include <unordered_set>

namespace covis {
namespace {

TEST(Id, ADefaultHandleIsInvalidAndSlotZeroIsNot) {
  EXPECT_FALSE(KeyFrameId{}.valid());
  EXPECT_TRUE((KeyFrameId{0, 0}.valid()));
  EXPECT_NE((MapPointId{3, 1}), (MapPointId{3, 2})) << "the same slot, used again";
  static_assert(!std::is_convertible_v<KeyFrameId, MapPointId>);
}

TEST(Id, OrderIsBySlotThenGeneration) {
  EXPECT_LT((MapPointId{1, 9}), (MapPointId{2, 0}));
  EXPECT_LT((MapPointId{2, 0}), (MapPointId{2, 1}));
  EXPECT_LT((MapPointId{2, 1}), MapPointId{});
}

TEST(Id, HashTellsSlotsAndGenerationsApart) {
  std::unordered_set<size_t> hashes;
  for (uint32_t slot = 0; slot < 50; ++slot) {
    for (uint32_t generation = 0; generation < 50; ++generation)
      hashes.insert(std::hash<MapPointId>{}({slot, generation}));
  }
  EXPECT_EQ(hashes.size(), 2500u);
}

}  // namespace
}  // namespace covis
