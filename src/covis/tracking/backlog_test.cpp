// SPDX-License-Identifier: Apache-2.0
#include "covis/tracking/backlog.h"

#include <gmock/gmock.h>

#include "covis/features/test_features.h"

namespace covis {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

class BacklogTest : public testing::Test {
 protected:
  TrackedFrame tracked(int64_t frame) const {
    TrackedFrame tracked;
    tracked.start(features, frame, 10 * frame);
    return tracked;
  }
  void keep(int64_t frame) { backlog.keep(tracked(frame)); }
  std::vector<int64_t> taken() {
    std::vector<int64_t> indices;
    for (const UnlocatedFrame& frame : backlog.take()) indices.push_back(frame.frame);
    return indices;
  }

  const FeaturesPtr features = std::make_shared<const Features>(no_features());
  const KeyFrameId here{1, 1}, there{2, 1};
  Backlog backlog;
};

TEST_F(BacklogTest, GivesFramesNewestFirstOnceThePlaceIsSure) {
  for (const int64_t frame : {3, 4, 6}) keep(frame);
  backlog.found_at(here);
  EXPECT_THAT(taken(), IsEmpty()) << "the place may not hold";
  EXPECT_EQ(backlog.take_with_found().size(), 3u);
  EXPECT_EQ(backlog.take_with_found().size(), 3u) << "copies";
  backlog.settle();
  const std::vector<UnlocatedFrame> frames = backlog.take();
  ASSERT_EQ(frames.size(), 3u);
  EXPECT_EQ(frames[0].frame, 6);
  EXPECT_EQ(frames[2].frame, 3);
  EXPECT_EQ(frames[2].stamp, 30);
  EXPECT_EQ(frames[2].features, features);
  EXPECT_EQ(frames[2].near, here);
  EXPECT_THAT(taken(), IsEmpty()) << "each is given once";
}

TEST_F(BacklogTest, AtTheEndThoseWhosePlaceIsSureAreGivenOnce) {
  keep(1);
  backlog.found_at(here);
  backlog.settle();
  keep(5);
  EXPECT_EQ(backlog.take_with_found().size(), 1u) << "nobody knows where the later one is";
  backlog.found_at(there);
  const std::vector<UnlocatedFrame> frames = backlog.take_with_found();
  ASSERT_EQ(frames.size(), 1u);
  EXPECT_EQ(frames[0].frame, 5);
  backlog.settle();
  EXPECT_EQ(backlog.take_with_found().size(), 1u);
  EXPECT_THAT(backlog.take_with_found(), IsEmpty());
  EXPECT_THAT(taken(), IsEmpty());
}

TEST_F(BacklogTest, EachGapKeepsItsPlace) {
  keep(1);
  backlog.found_at(here);
  backlog.settle();
  backlog.lost();
  keep(5);
  backlog.found_at(there);
  backlog.settle();
  const std::vector<UnlocatedFrame> frames = backlog.take();
  ASSERT_EQ(frames.size(), 2u);
  EXPECT_EQ(frames[0].near, there);
  EXPECT_EQ(frames[1].near, here);
}

TEST_F(BacklogTest, APlaceThatDoesNotHoldIsNoPlace) {
  keep(1);
  backlog.found_at(here);
  backlog.lost();
  EXPECT_TRUE(backlog.take_with_found().empty());
  backlog.found_at(there);
  backlog.settle();
  const std::vector<UnlocatedFrame> frames = backlog.take();
  ASSERT_EQ(frames.size(), 1u);
  EXPECT_EQ(frames[0].near, there);
}

TEST_F(BacklogTest, FramesWhosePosesMayBeTakenBackWaitOnlyIfTheCameraIsLost) {
  keep(1);
  backlog.found_at(here);
  backlog.keep_for_now(tracked(2));
  backlog.settle();
  EXPECT_THAT(taken(), ElementsAre(1));
  keep(4);
  for (const int64_t frame : {5, 6}) {
    backlog.found_at(here);
    backlog.keep_for_now(tracked(frame));
  }
  backlog.lost();
  keep(7);
  backlog.found_at(there);
  backlog.settle();
  EXPECT_THAT(taken(), ElementsAre(7, 6, 5, 4));
}

TEST_F(BacklogTest, TheOldestGoes) {
  constexpr int64_t kMany = 1000;
  for (int64_t frame = 0; frame < kMany; ++frame) keep(frame);
  EXPECT_LT(features.use_count(), 200);
  backlog.found_at(here);
  backlog.settle();
  const std::vector<int64_t> indices = taken();
  ASSERT_FALSE(indices.empty());
  EXPECT_EQ(indices.front(), kMany - 1);
  EXPECT_EQ(indices.back(), kMany - static_cast<int64_t>(indices.size()));
}

}  // namespace
}  // namespace covis
