// SPDX-License-Identifier: Apache-2.0
#include "covis/map/slot_store.h"

#include <gtest/gtest.h>

#include "covis/core/ids.h"

namespace covis {
namespace {

TEST(SlotStore, StaleHandlesFindNothing) {
  SlotStore<MapPointId, int> store;
  const MapPointId a = store.insert(1), b = store.insert(2);
  EXPECT_TRUE(store.erase(a));
  EXPECT_FALSE(store.erase(a));
  EXPECT_EQ(store.find(a), nullptr);
  const MapPointId c = store.insert(3);
  EXPECT_EQ(c.slot, a.slot);
  EXPECT_NE(c, a);
  EXPECT_EQ(store.find(a), nullptr);
  EXPECT_EQ(store.at(b), 2);
  EXPECT_EQ(store.size(), 2u);
}

}  // namespace
}  // namespace covis
