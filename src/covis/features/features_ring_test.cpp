// SPDX-License-Identifier: Apache-2.0
#include "covis/features/features_ring.h"

#include <gtest/gtest.h>

#include <set>
#include <vector>

namespace covis {
namespace {

TEST(FeaturesRing, WhatNobodyHoldsIsUsedAgain) {
  FeaturesRing ring;
  std::set<const Features*> used;
  std::shared_ptr<Features> last;
  for (int frame = 0; frame < 12; ++frame) {
    std::shared_ptr<Features> now = ring.next();
    EXPECT_NE(now, last) << "those of the last frame are held";
    used.insert(now.get());
    last = now;
  }
  EXPECT_EQ(used.size(), 3u);
}

TEST(FeaturesRing, WhatSomebodyHoldsIsNotTouched) {
  FeaturesRing ring;
  std::vector<std::shared_ptr<const Features>> held;
  for (int frame = 0; frame < 12; ++frame) held.push_back(ring.next());
  EXPECT_EQ(std::set(held.begin(), held.end()).size(), held.size());
}

}  // namespace
}  // namespace covis
