// SPDX-License-Identifier: Apache-2.0
#include "apps/run/run_record.h"

#include <gtest/gtest.h>

namespace covis::app {
namespace {

FrameReport report(TrackingState state) {
  FrameReport made;
  made.track.state = state;
  made.track.reason = state == TrackingState::tracking ? NoPoseReason::none : NoPoseReason::few_map_points_agree;
  made.timing.total_ms = 9;
  made.timing.wait_ms = 2;
  return made;
}

TEST(RunRecord, AFrameKeepsWhatWasReported) {
  io::Frame frame;
  frame.index = 7;
  frame.stamp = 70;
  const FrameStats row = tracked_frame(frame, report(TrackingState::lost), RunMode::mapping);
  EXPECT_EQ(row.frame, 7);
  EXPECT_EQ(row.stamp, 70);
  EXPECT_EQ(row.state, FrameState::lost);
  EXPECT_EQ(row.reason, "too few points of the map agree on a pose");
  EXPECT_EQ(row.tracking_ms(), 7);
  EXPECT_TRUE(row.processed());
}

TEST(RunRecord, LostFramesOfALocalizationAreNotLocalised) {
  const auto state = [](TrackingState tracked) {
    return tracked_frame({}, report(tracked), RunMode::localization).state;
  };
  EXPECT_EQ(state(TrackingState::lost), FrameState::not_localised);
  EXPECT_EQ(state(TrackingState::tracking), FrameState::tracking);
  EXPECT_EQ(state(TrackingState::not_initialised), FrameState::not_initialised);
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
  const auto pose_of = [](int64_t frame) {
    PoseOfFrame pose;
    pose.frame = frame;
    return pose;
  };
  SpilledArray<FrameStats> frames;
  for (int64_t frame = 0; frame < 6; ++frame) frames.push_back(skipped_frame(frame, 0, FrameState::lost, "why"));
  for (const size_t tracked : {0, 1, 2}) {
    frames[tracked].state = FrameState::tracking;
    frames[tracked].reason = "";
    frames[tracked].track.method = TrackMethod::recovered;
    frames[tracked].track.tentative = tracked > 0;
  }
  Snapshot snapshot;
  for (const int64_t frame : {0, 2, 3, 4}) snapshot.trajectory.push_back(pose_of(frame));
  snapshot.online = {pose_of(0)};
  snapshot.key_frames.resize(1);
  snapshot.key_frames[0].frame = 4;
  settle_states(snapshot, RunMode::mapping, frames);
  EXPECT_EQ(frames[0].track.method, TrackMethod::recovered) << "as it was";
  EXPECT_EQ(frames[1].state, FrameState::lost) << "its pose was taken back";
  EXPECT_NE(frames[1].reason, "");
  EXPECT_EQ(frames[2].track.method, TrackMethod::backtracked) << "taken back, and located afterwards";
  EXPECT_EQ(frames[3].track.method, TrackMethod::backtracked);
  EXPECT_EQ(frames[4].track.method, TrackMethod::initialised) << "the first view of a map";
  for (const size_t located : {2, 3, 4}) {
    EXPECT_EQ(frames[located].state, FrameState::tracking);
    EXPECT_FALSE(frames[located].track.tentative);
    EXPECT_EQ(frames[located].reason, "");
  }
  EXPECT_EQ(frames[5].state, FrameState::lost);
  EXPECT_EQ(frames[5].reason, "why") << "it had no pose to lose";
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
