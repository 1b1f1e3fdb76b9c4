// SPDX-License-Identifier: Apache-2.0
#include "apps/run/run_record.h"

#include <gtest/gtest.h>

namespace covis::app {
namespace {

FrameReport report(TrackState state) {
  FrameReport made;
  made.track.state = state;
  made.track.reason = state == TrackState::tracking ? "" : "too few matches";
  made.timing.total_ms = 9;
  made.timing.wait_ms = 2;
  return made;
}

TEST(RunRecord, AFrameKeepsWhatWasReported) {
  io::Frame frame;
  frame.index = 7;
  frame.stamp = 70;
  const FrameStats row = tracked_frame(frame, report(TrackState::lost), RunMode::mapping);
  EXPECT_EQ(row.frame, 7);
  EXPECT_EQ(row.stamp, 70);
  EXPECT_EQ(row.state, FrameState::lost);
  EXPECT_EQ(row.reason, "too few matches");
  EXPECT_EQ(row.tracking_ms(), 7);
  EXPECT_TRUE(row.processed());
}

TEST(RunRecord, LostFramesOfALocalizationAreNotLocalised) {
  const auto state = [](TrackState tracked) { return tracked_frame({}, report(tracked), RunMode::localization).state; };
  EXPECT_EQ(state(TrackState::lost), FrameState::not_localised);
  EXPECT_EQ(state(TrackState::tracking), FrameState::tracking);
  EXPECT_EQ(state(TrackState::not_initialised), FrameState::not_initialised);
}

TEST(RunRecord, SkippedFramesWereNotProcessed) {
  for (const FrameState state : {FrameState::late, FrameState::unreadable}) {
    const FrameStats row = skipped_frame(3, 30, state, "why");
    EXPECT_FALSE(row.processed());
    EXPECT_EQ(row.frame, 3);
    EXPECT_EQ(row.reason, "why");
  }
}

TEST(RunRecord, PosesTakenBackOrFoundAfterwardsShowInTheirRows) {
  std::vector<FrameStats> frames;
  for (const int64_t index : {10, 20, 30, 40}) frames.push_back(skipped_frame(index, 0, FrameState::tracking, ""));
  frames[2].state = FrameState::not_initialised;
  frames[1].state = FrameState::lost;
  frames[1].reason = "why";
  frames[1].track.tentative = true;
  std::vector<PoseOfFrame> trajectory(3);  // neither frame 30 nor frame 40 is among them
  for (size_t k = 0; k < trajectory.size(); ++k) trajectory[k].frame = std::array{10, 15, 20}[k];
  settle_states(trajectory, RunMode::mapping, frames);
  EXPECT_EQ(frames[0].state, FrameState::tracking);
  EXPECT_EQ(frames[0].track.method, TrackMethod::none) << "as it was";
  EXPECT_EQ(frames[1].state, FrameState::tracking) << "it got its pose afterwards";
  EXPECT_EQ(frames[1].track.method, TrackMethod::backtracked);
  EXPECT_EQ(frames[1].reason, "");
  EXPECT_FALSE(frames[1].track.tentative);
  EXPECT_EQ(frames[2].state, FrameState::not_initialised) << "it had no pose to lose";
  EXPECT_EQ(frames[3].state, FrameState::lost);
  EXPECT_NE(frames[3].reason, "");
  settle_states({}, RunMode::localization, frames);
  EXPECT_EQ(frames[0].state, FrameState::not_localised);
}

TEST(RunRecord, EveryStateHasItsName) {
  std::vector<std::string_view> names;
  for (int state = 0; state <= static_cast<int>(FrameState::unreadable); ++state)
    names.push_back(name(static_cast<FrameState>(state)));
  EXPECT_EQ(names, (std::vector<std::string_view>{"tracking", "lost", "not_initialised", "not_localised", "late",
                                                  "unreadable"}));
}

}  // namespace
}  // namespace covis::app
