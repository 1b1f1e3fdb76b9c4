// SPDX-License-Identifier: Apache-2.0
#include "covis/types.h"

#include <gtest/gtest.h>

#include <set>
#include <string>

namespace covis {
namespace {

TEST(TrackingStateName, IsItsWord) {
  EXPECT_STREQ(name(TrackingState::not_initialised), "not_initialised");
  EXPECT_STREQ(name(TrackingState::tracking), "tracking");
  EXPECT_STREQ(name(TrackingState::lost), "lost");
}

TEST(NoPoseReasonName, EachHasANameAndWordsOfItsOwn) {
  std::set<std::string> names, words;
  constexpr int kLast = static_cast<int>(NoPoseReason::no_key_frame_matches);
  for (int k = 0; k <= kLast; ++k) {
    const auto reason = static_cast<NoPoseReason>(k);
    EXPECT_TRUE(names.insert(name(reason)).second) << name(reason);
    EXPECT_TRUE(words.insert(describe(reason)).second) << describe(reason);
  }
  EXPECT_STREQ(name(NoPoseReason::low_parallax), "low_parallax");
  EXPECT_STREQ(describe(NoPoseReason::none), "");
}

}  // namespace
}  // namespace covis
