// SPDX-License-Identifier: Apache-2.0
#include "covis/core/reserve.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <vector>

namespace covis {
namespace {

TEST(ReserveOneMore, LeavesLittleUnusedAndMovesSeldom) {
  std::vector<uint32_t> list;
  size_t moved = 0;  // elements, in all
  for (uint32_t i = 0; i < 1000; ++i) {
    const size_t before = list.capacity();
    reserve_one_more(list);
    if (list.capacity() != before) moved += list.size();
    ASSERT_GT(list.capacity(), list.size());
    list.push_back(i);
    EXPECT_LE(list.capacity(), list.size() + list.size() / 4 + 6);
  }
  EXPECT_LT(moved, 6000u);
  EXPECT_EQ(list[777], 777u);
}

TEST(AtSlot, MakesRoomForASlotBeyondTheEnd) {
  std::vector<int> marks;
  at_slot(marks, 1000) = 7;
  EXPECT_GT(marks.size(), 1000u);
  EXPECT_EQ(at_slot(marks, 1000), 7);
  EXPECT_EQ(at_slot(marks, 1001), 0);
  const size_t size = marks.size();
  at_slot(marks, size - 1) = 1;
  EXPECT_EQ(marks.size(), size);
}

}  // namespace
}  // namespace covis
