// SPDX-License-Identifier: Apache-2.0
// For tests: the tracker with the mapper called in turn, no threads.
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <memory>
#include <utility>
#include <variant>

#include "covis/mapping/mapper.h"
#include "covis/tracking/test_frames.h"
#include "covis/tracking/tracker.h"

namespace covis {

// The key frame that is asked for after a frame; null when none is.
inline const KeyFrameRequest* key_frame_of(const Tracker::Outcome& outcome) {
  return std::get_if<KeyFrameRequest>(&outcome.request);
}

// The vocabulary of this repository.
inline std::shared_ptr<const Vocabulary> vocabulary() {
  return Vocabulary::load(std::filesystem::path(COVIS_SOURCE_DIR) / "vocabulary/default.covis-voc").value();
}

class TrackerTest : public testing::Test {
 protected:
  explicit TrackerTest(const TrackingSettings& wanted = settings_of(Sensor::rgbd),
                       const std::shared_ptr<const Vocabulary>& vocabulary = nullptr)
      : frames(TestFrames::of(wanted.sensor)),
        settings(wanted),
        tracker(shared, settings, vocabulary),
        mapper(shared, settings.sensor, {}, settings.options.key_frame.close_depth, vocabulary) {}

  static TrackingSettings settings_of(Sensor sensor) {
    TrackingSettings settings;
    settings.sensor = sensor;
    return settings;
  }
  // The tracker's requests are left to the test.
  Tracker::Outcome track_alone(FeaturesPtr features, int i) {
    return tracker.track(std::move(features), i, frames.stamp(i), {});
  }
  void do_mapping(const Tracker::Outcome& outcome) {
    if (outcome.discard_submap) shared.write()->erase_submap(*outcome.discard_submap);
    if (const KeyFrameRequest* key_frame = key_frame_of(outcome))
      tracker.key_frame_made(mapper.process(*key_frame, nullptr));
    if (const auto* initial_map = std::get_if<InitialMapRequest>(&outcome.request))
      tracker.key_frame_made(mapper.initialise(*initial_map));
  }
  TrackResult track(FeaturesPtr features, int i) {
    const Tracker::Outcome outcome = track_alone(std::move(features), i);
    do_mapping(outcome);
    EXPECT_EQ(outcome.result.state == TrackingState::tracking, outcome.result.reason == NoPoseReason::none)
        << describe(outcome.result.reason);
    return outcome.result;
  }
  TrackResult track(int i) { return track(frames.features(i), i); }
  TrackResult track_blank(int i) { return track(frames.blank(), i); }

  TestFrames& frames;
  SharedMap shared{frames.camera()};
  TrackingSettings settings;
  Tracker tracker;
  Mapper mapper;
};

class MonocularTrackerTest : public TrackerTest {
 protected:
  MonocularTrackerTest() : TrackerTest(settings_of(Sensor::monocular)) {}
};

}  // namespace covis
