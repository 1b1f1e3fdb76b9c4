// SPDX-License-Identifier: Apache-2.0
// For tests: the tracker with the mapper called in turn, no threads.
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <memory>
#include <utility>

#include "covis/slam/backend.h"
#include "covis/slam/test_frames.h"
#include "covis/slam/tracker.h"

namespace covis {

// The one that comes along.
inline std::shared_ptr<const Vocabulary> vocabulary() {
  return Vocabulary::load(std::filesystem::path(COVIS_SOURCE_DIR) / "vocabulary/default.covis-voc").value();
}

class TrackerTest : public testing::Test {
 protected:
  explicit TrackerTest(const SystemOptions& wanted = options_of(Sensor::rgbd),
                       std::shared_ptr<const Vocabulary> vocabulary = nullptr)
      : frames(TestFrames::of(wanted.sensor)),
        options(wanted),
        tracker(shared, options, vocabulary),
        mapper(shared, BackendOptions(options), vocabulary) {}

  static SystemOptions options_of(Sensor sensor) {
    SystemOptions options;
    options.sensor = sensor;
    return options;
  }
  // What the tracker asks for is left to the test.
  Tracker::Outcome track_alone(FeaturesPtr features, int i) {
    Tracker::Outcome outcome = tracker.track(std::move(features), i, frames.stamp(i), true, true);
    EXPECT_FALSE(outcome.key_frame && outcome.initial_map);
    return outcome;
  }
  void do_mapping(const Tracker::Outcome& outcome) {
    if (outcome.key_frame) tracker.key_frame_made(mapper.process(*outcome.key_frame, nullptr));
    if (outcome.initial_map) tracker.key_frame_made(mapper.initialise(*outcome.initial_map));
    if (outcome.discard_submap) mapper.discard(*outcome.discard_submap);
  }
  TrackResult track(FeaturesPtr features, int i) {
    const Tracker::Outcome outcome = track_alone(std::move(features), i);
    do_mapping(outcome);
    EXPECT_EQ(outcome.result.state == TrackState::tracking, outcome.result.reason.empty()) << outcome.result.reason;
    return outcome.result;
  }
  TrackResult track(int i) { return track(frames.features(i), i); }
  TrackResult track_blank(int i) { return track(frames.blank(), i); }

  TestFrames& frames;
  SharedMap shared{frames.camera()};
  SystemOptions options;
  Tracker tracker;
  Backend mapper;
};

class MonocularTrackerTest : public TrackerTest {
 protected:
  MonocularTrackerTest() : TrackerTest(options_of(Sensor::monocular)) {}
};

}  // namespace covis
