// SPDX-License-Identifier: Apache-2.0
// The whole system with all its threads, on rendered recordings with exact ground truth.
#include <gmock/gmock.h>

#include "rendered.h"

namespace covis {
namespace {

class EachSensor : public testing::TestWithParam<Sensor> {};

INSTANTIATE_TEST_SUITE_P(Sensors, EachSensor, testing::Values(Sensor::monocular, Sensor::stereo, Sensor::rgbd),
                         [](const auto& instance) { return sensor_name(instance.param); });

// Tracks the recording and checks every frame's report and map. `bound` limits the final error, metres.
void expect_tracked(Recording& recording, Sensor sensor, double bound) {
  System system(recording.synth.camera(), options_for(sensor));
  int tracked = 0, mapped = 0;
  for (int i = 0; i < recording.size(); ++i) {
    const FrameReport report = system.process(recording.frame(i));
    tracked += report.track.state == TrackingState::tracking;
    mapped += static_cast<int>(report.mapping.size());
    ASSERT_EQ(system.map().read()->check(), "") << "after frame " << i;
    EXPECT_EQ(report.track.state == TrackingState::tracking, report.track.reason == NoPoseReason::none)
        << describe(report.track.reason);
  }
  system.finish();
  EXPECT_GE(tracked, sensor == Sensor::monocular ? recording.size() / 2 : recording.size());
  EXPECT_GT(mapped, 0);
  const auto poses = system.trajectory();
  EXPECT_GE(static_cast<int>(poses.size()), tracked);
  EXPECT_LT(error(poses, recording.synth, sensor == Sensor::monocular), bound);
  EXPECT_LT(error(system.online_trajectory(), recording.synth, sensor == Sensor::monocular), 1.5 * bound);
}

TEST_P(EachSensor, TracksARoom) {
  Recording& recording = shared_recording(GetParam(), 32);
  expect_tracked(recording, GetParam(), 0.04);
}

TEST_P(EachSensor, TracksARoomLong) {
  Recording& recording = shared_recording(GetParam(), 60, 30, "room", {640, 480});
  expect_tracked(recording, GetParam(), 0.02);
}

TEST_P(EachSensor, TwoRunsGiveTheSameBytesLong) {
  Recording& recording = shared_recording(GetParam(), 32);
  std::string first;
  for (int run = 0; run < 2; ++run) {
    System system(recording.synth.camera(), options_for(GetParam()));
    for (int i = 0; i < recording.size(); ++i) system.process(recording.frame(i));
    system.finish();
    const std::string result = bytes(system.trajectory()) + bytes(system.online_trajectory());
    EXPECT_FALSE(result.empty());
    if (run == 0) first = result;
    EXPECT_EQ(result, first);
  }
}

TEST(System, WhatMappingMadeShowsAfterItsDelayOrAtOnceNearALoss) {
  constexpr int kDelay = 4;
  SystemOptions options = options_for(Sensor::rgbd);
  options.mapping_delay = kDelay;
  options.tracker.local_map.min_inliers = 200;
  options.tracker.key_frame.min_close_points = 500;  // rarely reached, so that key frames are made often
  options.tracker.key_frame.new_close_points = 0;
  Recording& recording = shared_recording(Sensor::rgbd, 32);
  System system(recording.synth.camera(), options);
  int waited = 0, late = 0, at_once = 0;  // waited: frames since a key frame whose mapping is not visible yet; 0: none
  bool near_loss = false;
  for (int i = 0; i < recording.size(); ++i) {
    const FrameReport report = system.process(recording.frame(i));
    ASSERT_EQ(report.track.state, TrackingState::tracking) << i;
    if (i == 0) continue;
    if (waited > 0) {
      const bool due = waited == kDelay;
      ASSERT_EQ(report.mapping.size(), due || near_loss ? 1u : 0u) << i;
      late += due;
      at_once += !due && near_loss;
      waited = report.mapping.empty() ? waited + 1 : 0;
    }
    if (report.track.key_frame) waited = 1;
    near_loss = report.track.inliers < 2 * options.tracker.local_map.min_inliers;
  }
  EXPECT_GE(late, 1);
  EXPECT_GE(at_once, 1);
}

TEST_P(EachSensor, RealTimeTracksToo) {
  SystemOptions options = options_for(GetParam());
  options.realtime = true;
  Recording& recording = shared_recording(GetParam(), 24, 12, "desk");
  System system(recording.synth.camera(), options);
  int tracked = 0;
  for (int i = 0; i < recording.size(); ++i) {
    tracked += system.process(recording.frame(i)).track.state == TrackingState::tracking;
  }
  system.finish();
  EXPECT_GE(tracked, recording.size() / 3);
  EXPECT_EQ(system.map().read()->check(), "");
}

TEST_P(EachSensor, LossIsAStateWithAReasonAndIsRecoveredFrom) {
  constexpr int kSeen = 24, kBlack = 4, kAfter = 4;
  Recording& recording = shared_recording(GetParam(), kSeen + kBlack + kAfter, 15, "desk");
  System system(recording.synth.camera(), options_for(GetParam()));
  int i = 0;
  for (; i < kSeen; ++i) system.process(recording.frame(i));
  const size_t before = system.trajectory().size();
  ASSERT_GT(before, 5u);
  const size_t key_frames = system.map().read()->key_frame_count();
  for (; i < kSeen + kBlack; ++i) {
    const FrameReport report = system.process(recording.black(i));
    EXPECT_EQ(report.track.state, TrackingState::lost);
    EXPECT_NE(report.track.reason, NoPoseReason::none);
  }
  EXPECT_EQ(system.trajectory().size(), before) << "a pose was invented";
  EXPECT_GE(system.map().read()->key_frame_count(), key_frames);
  int recovered = 0;
  for (; i < recording.size(); ++i) {
    recovered += system.process(recording.frame(i)).track.state == TrackingState::tracking;
  }
  EXPECT_GE(recovered, kAfter - 1);
  system.finish();
  EXPECT_LT(error(system.trajectory(), recording.synth, GetParam() == Sensor::monocular), 0.02);
}

// The walk back from where the map begins ends at frames that show nothing; those before them are found by their place.
TEST(System, FramesThatTheWalkDoesNotReachAreLocatedAtTheEndLong) {
  constexpr int kAll = 60, kStood = 12, kBlack = 6;
  Recording& recording = shared_recording(Sensor::monocular, kAll);
  System system(recording.synth.camera(), options_for(Sensor::monocular), vocabulary());
  for (int i = 0; i < kStood + kBlack; ++i) {
    System::Input input = i < kStood ? recording.frame(0) : recording.black(0);
    input.frame = i;
    input.stamp = recording.synth.stamp(0) + from_seconds(0.04 * (i - kStood - kBlack));
    system.process(input);
  }
  for (int i = 0; i < kAll; ++i) {
    System::Input input = recording.frame(i);
    input.frame = kStood + kBlack + i;
    system.process(input);
  }
  system.finish();
  std::vector<PoseOfFrame> poses = system.trajectory();
  EXPECT_EQ(poses.size(), size_t{kStood + kAll}) << "all but those that show nothing";
  EXPECT_EQ(poses.front().frame, 0);
  for (PoseOfFrame& pose : poses) pose.frame = std::max<int64_t>(0, pose.frame - kStood - kBlack);
  EXPECT_LT(error(poses, recording.synth, true), 0.02);
}

TEST(System, NothingToSeeIsNotInitialised) {
  for (const Sensor sensor : {Sensor::monocular, Sensor::stereo, Sensor::rgbd}) {
    Recording& recording = shared_recording(sensor, 1, 8, "room", {160, 120});
    System system(recording.synth.camera(), options_for(sensor));
    for (int i = 0; i < 3; ++i) {
      const FrameReport report = system.process(recording.black(i));
      EXPECT_EQ(report.track.state, TrackingState::not_initialised);
      EXPECT_NE(report.track.reason, NoPoseReason::none);
    }
    system.finish();
    EXPECT_TRUE(system.trajectory().empty());
  }
}

TEST(System, LocalisationWithoutAMapBeginsNone) {
  for (const Sensor sensor : {Sensor::monocular, Sensor::rgbd}) {
    SystemOptions options = options_for(sensor);
    options.localize = true;
    options.tracker.start.new_map_after = 0.1;
    Recording& recording = shared_recording(sensor, 6, 8, "desk");
    System system(recording.synth.camera(), options, vocabulary());
    for (int i = 0; i < recording.size(); ++i) {
      const TrackResult track = system.process(recording.frame(i)).track;
      EXPECT_EQ(track.state, TrackingState::lost);
      EXPECT_EQ(track.reason, NoPoseReason::no_map_to_localise_in);
      EXPECT_FALSE(track.key_frame);
    }
    system.finish();
    EXPECT_TRUE(system.submaps().empty());
    EXPECT_EQ(system.snapshot()->points.size(), 0u);
  }
}

// Small images of a world in which things move, 15 a second, by RGB-D. Returns the error of the path.
double error_among_moving(const std::string& world, int seed, int moving, int frames) {
  SynthOptions options;
  options.world = world;
  options.seed = seed;
  options.moving = moving;
  options.frames = frames;
  options.fps = 15;
  options.width = 320;
  options.height = 240;
  Recording recording(options);
  System system(recording.synth.camera(), options_for(Sensor::rgbd));
  for (int i = 0; i < recording.size(); ++i)
    EXPECT_EQ(system.process(recording.frame(i)).track.state, TrackingState::tracking) << i;
  system.finish();
  return error(system.trajectory(), recording.synth, false);
}

// The depths of somebody two metres ahead are so precise that they said the camera stood: it was 0.15 m off, of 8 m.
TEST(System, APersonWalkingAheadDoesNotHoldTheCameraBack) { EXPECT_LT(error_among_moving("corridor", 1, 1, 90), 0.03); }

// Three people cover up to half of the image, and pause where they turn round. New points on them took the camera with
// them: it was 0.28 m off, of 3.8 m.
TEST(System, PeopleWalkingInFrontOfTheCameraDoNotTakeItWithThemLong) {
  EXPECT_LT(error_among_moving("room", 6, 3, 120), 0.02);
}

// 160x120 pixels have room for some 150 keypoints, and a frame of good texture has 300.
TEST(System, AMapBeginsOnSmallImagesToo) {
  Recording& recording = shared_recording(Sensor::rgbd, 2, 30, "room", {160, 120});
  System system(recording.synth.camera(), options_for(Sensor::rgbd));
  for (int i = 0; i < recording.size(); ++i)
    EXPECT_EQ(system.process(recording.frame(i)).track.state, TrackingState::tracking) << i;
}

TEST(System, StartsAndStopsAtAnyTime) {
  Recording& recording = shared_recording(Sensor::stereo, 4, 8, "desk", {160, 120});
  SystemOptions options = options_for(Sensor::stereo);
  options.orb.features = 200;
  options.orb.levels = 3;
  options.tracker.start.init_features = 60;
  size_t key_frames = 0;
  for (int cycle = 0; cycle < 200; ++cycle) {
    System system(recording.synth.camera(), options);
    for (int i = 0; i < cycle % 5; ++i) system.process(recording.frame(i));
    if (cycle % 2) system.finish();
    key_frames += system.map().read()->key_frame_count();
  }
  EXPECT_GE(key_frames, 160u) << "the mapping thread had nothing to do";
}

}  // namespace
}  // namespace covis
