// SPDX-License-Identifier: Apache-2.0
// The tracker where the map moves, has several submaps, or knows too little.
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <numbers>
#include <vector>

#include "covis/tracking/test_tracker.h"

namespace covis {
namespace {

class SeveralMapsTest : public TrackerTest {
 protected:
  SeveralMapsTest() : TrackerTest(many_key_frames(), vocabulary()) {}

  static TrackingSettings many_key_frames() {
    TrackingSettings settings = settings_of(Sensor::rgbd);
    settings.options.key_frame.min_close_points = 500;  // to be content with: rarely reached
    settings.options.key_frame.new_close_points = 0;
    return settings;
  }

  // Tracks until the camera has been lost for long; returns the next frame.
  int lose_for_long(int i) {
    const Timestamp since = frames.stamp(i);
    for (; frames.stamp(i) - since < from_seconds(settings.options.start.new_map_after); ++i) {
      EXPECT_EQ(track_blank(i).state, TrackingState::lost);
    }
    return i;
  }
};

double distance(const TrackResult& result, const SE3& T_cw) {
  return (result.T_cw.inverse().t() - T_cw.inverse().t()).norm();
}

class NoMotionModelTest : public TrackerTest {
 protected:
  NoMotionModelTest() : TrackerTest(without_motion_model()) {}

  static TrackingSettings without_motion_model() {
    TrackingSettings settings = settings_of(Sensor::rgbd);
    settings.options.first_pose.motion_min_matches = 100000;
    return settings;
  }
};

TEST_F(NoMotionModelTest, TheReferenceKeyFrameIsWhereTheMapMovedIt) {
  for (int i = 0; i < 6; ++i) ASSERT_EQ(track(i).state, TrackingState::tracking);
  const SE3 S(so3_exp({0, 0, std::numbers::pi / 2}), {30, 10, 0});
  {
    const auto map = shared.write();
    for (const KeyFrameId& id : map->key_frames()) map->set_pose(id, map->at(id).T_cw * S.inverse());
    std::vector<MapPointId> points;
    map->for_each_point([&](MapPointId id, const MapPoint&) { points.push_back(id); });
    for (const MapPointId id : points) map->set_position(id, S * map->at(id).position_w);
    for (const MapPointId id : points) map->refresh_point(id);
  }
  tracker.map_moved();
  const TrackResult result = track(frames.features(0), 6);
  ASSERT_EQ(result.state, TrackingState::tracking) << describe(result.reason);
  EXPECT_EQ(result.method, TrackMethod::reference_key_frame);
  EXPECT_LT(distance(result, frames.T_cw(0) * S.inverse()), 0.01);
}

TEST_F(SeveralMapsTest, AGapIsNotLocatedFromAPlaceThatProvesWrongWithoutALoss) {
  for (int i = 0; i < frames.count(); ++i) ASSERT_EQ(track(i).state, TrackingState::tracking);
  int i = frames.count();
  const auto show = [&](FeaturesPtr features) {
    const Tracker::Outcome outcome = track_alone(std::move(features), i++);
    do_mapping(outcome);
    return outcome;
  };
  ASSERT_EQ(show(frames.blank()).result.state, TrackingState::lost);
  const TrackResult first = show(frames.features(0)).result;
  ASSERT_TRUE(first.tentative);
  EXPECT_TRUE(tracker.take_unlocated().empty()) << "the place is in doubt";
  const Tracker::Outcome second = show(frames.features(frames.count() - 1));  // jumps again, and is not lost
  ASSERT_TRUE(second.retract_from);
  ASSERT_TRUE(second.result.tentative);
  TrackResult last = second.result;
  for (int k = 2; last.tentative && k < frames.count(); ++k) last = show(frames.features(frames.count() - k)).result;
  ASSERT_EQ(last.state, TrackingState::tracking);
  const std::vector<UnlocatedFrame> waiting = tracker.take_unlocated();
  ASSERT_EQ(waiting.size(), 2u) << "the blank one, and the one whose pose was taken back";
  EXPECT_EQ(waiting.front().near, second.result.pose.key_frame);
  EXPECT_EQ(waiting.back().near, second.result.pose.key_frame);
}

// Either may be wrong; a contradiction that lasts speaks against the map.
TEST_F(SeveralMapsTest, DepthThatContradictsTheMapForLongBeginsAnother) {
  for (int i = 0; i < 4; ++i) ASSERT_EQ(track(i).state, TrackingState::tracking);
  int begun = -1;
  for (int i = 4; i < frames.count(); ++i) {
    auto other = std::make_shared<Features>(*frames.features(i));
    for (float& depth : other->depth) depth *= 1.5f;
    const TrackResult result = track(other, i);
    ASSERT_EQ(result.state, TrackingState::tracking) << "frame " << i << ": " << describe(result.reason);
    if (result.method == TrackMethod::initialised) {
      ASSERT_EQ(begun, -1) << "one suffices";
      begun = i;
    } else {
      EXPECT_EQ(result.tentative, begun < 0 || i < begun + 16) << "frame " << i << ": two seconds until it is sure";
      EXPECT_EQ(result.submap == 0, begun < 0) << "frame " << i;
    }
  }
  EXPECT_NEAR(begun, 8, 1) << "as long as they agreed";
  EXPECT_EQ(shared.read()->submaps().size(), 2u);
}

// A map made of wrong depth is left for the older one when depth is right again.
TEST_F(SeveralMapsTest, WhereDepthBlamesTheMapTheCameraComesBackToAnOlderOne) {
  int back = -1;
  for (int i = 0; i < frames.count(); ++i) {
    auto features = std::make_shared<Features>(*frames.features(i));
    for (float& depth : features->depth) depth *= i >= 4 && i < 12 ? 1.5f : 1;
    const TrackResult result = track(features, i);
    ASSERT_EQ(result.state, TrackingState::tracking) << "frame " << i << ": " << describe(result.reason);
    if (back < 0 && i >= 12 && result.submap == 0) {
      back = i;
      EXPECT_EQ(result.method, TrackMethod::recovered);
    }
    if (back < 0) continue;
    EXPECT_EQ(result.submap, 0u) << "frame " << i;
    EXPECT_FALSE(result.tentative) << "frame " << i
                                   << ": it is near where it was in that map, which is on no probation";
    EXPECT_LT(distance(result, frames.T_cw(i)), 0.03) << "frame " << i;
  }
  EXPECT_NEAR(back, 16, 2) << "half a second later";
  EXPECT_EQ(shared.read()->submaps().size(), 2u);
}

TEST_F(SeveralMapsTest, TheCameraComesBackToANewerMapAsWell) {
  std::vector<uint32_t> submaps;  // those it went through
  for (int i = 0; i < 60; ++i) {
    const int there = i % (2 * frames.count() - 2), k = std::min(there, 2 * frames.count() - 2 - there);  // to and fro
    auto features = std::make_shared<Features>(*frames.features(k));
    for (float& depth : features->depth) depth *= (i >= 4 && i < 12) || i >= 24 ? 1.5f : 1;
    const TrackResult result = track(features, i);
    ASSERT_EQ(result.state, TrackingState::tracking) << "frame " << i << ": " << describe(result.reason);
    if (submaps.empty() || submaps.back() != result.submap) submaps.push_back(result.submap);
  }
  EXPECT_EQ(submaps, (std::vector<uint32_t>{0, 1, 0, 1}));
  EXPECT_EQ(shared.read()->submaps().size(), 2u);
}

TEST_F(SeveralMapsTest, AMapOnProbationIsSureOnceMotionSaysThatDepthIsRight) {
  MappingStatus status;
  int begun = -1;
  for (int i = 0; i < frames.count() && (begun < 0 || i < begun + 4); ++i) {
    auto other = std::make_shared<Features>(*frames.features(i));
    for (float& depth : other->depth) depth *= i < 4 ? 1 : 1.5f;
    status.depth = begun >= 0 && i >= begun + 3 ? MappingStatus::Depth::right : MappingStatus::Depth::unknown;
    const Tracker::Outcome outcome = tracker.track(other, i, frames.stamp(i), status);
    do_mapping(outcome);
    if (i > 0 && outcome.result.method == TrackMethod::initialised) begun = i;
    if (begun >= 0) {
      EXPECT_EQ(outcome.result.tentative, i < begun + 3) << "frame " << i;
    }
  }
  ASSERT_GE(begun, 0);
}

// Nothing has shown that a map on probation was ever right: the camera has been lost since it was begun.
TEST_F(SeveralMapsTest, AMapThatIsLostOnProbationIsFollowedByAnotherSoon) {
  int begun = -1, lost = 0;
  for (int i = 0; i < frames.count(); ++i) {
    const bool elsewhere = begun >= 0 && i >= begun + 6;
    auto features = std::make_shared<Features>(elsewhere ? *frames.elsewhere(0) : *frames.features(i));
    for (float& depth : features->depth) depth *= i < 4 || elsewhere ? 1 : 1.5f;
    const TrackResult result = track(features, i);
    if (begun < 0) {
      if (i > 0 && result.method == TrackMethod::initialised) begun = i;
      EXPECT_EQ(result.doubts.map_on_probation, begun >= 0) << "frame " << i;
    } else if (result.state == TrackingState::lost) {
      ++lost;
    } else if (elsewhere) {
      ASSERT_EQ(result.method, TrackMethod::initialised);
      break;
    }
  }
  EXPECT_EQ(lost, 2) << "it is looked for in three frames, and not for half a second";
}

TEST_F(SeveralMapsTest, ANewMapThatDoesNotHoldLeavesTheOldOneInUse) {
  for (int i = 0; i < 4; ++i) track(i);
  int i = lose_for_long(4);
  const Tracker::Outcome begun = track_alone(frames.elsewhere(0), i);
  ASSERT_TRUE(key_frame_of(begun));
  KeyFrameMade older;  // may come first
  older.key_frame = shared.read()->root();
  tracker.key_frame_made(older);
  tracker.key_frame_made({.frame = i});
  EXPECT_EQ(tracker.state(), TrackingState::lost);
  const size_t key_frames = shared.read()->key_frame_count();
  TrackResult result = track(frames.features(3), ++i);
  EXPECT_EQ(result.method, TrackMethod::recovered);
  for (int k = 4; k < frames.count(); ++k) {
    result = track(frames.features(k), ++i);
    EXPECT_EQ(result.state, TrackingState::tracking) << "frame " << k;
  }
  EXPECT_GT(shared.read()->key_frame_count(), key_frames) << "it goes on growing";
}

TEST_F(SeveralMapsTest, AReportOfTheOldMapDoesNotPassForTheNewOnes) {
  KeyFrameMade late;
  int late_frame = -1, i = 0;
  for (; late_frame < 0 && i < frames.count(); ++i) {
    const Tracker::Outcome outcome = track_alone(frames.features(i), i);
    if (!key_frame_of(outcome)) continue;
    const KeyFrameMade report = mapper.process(*key_frame_of(outcome), nullptr);
    if (i == 0) {
      tracker.key_frame_made(report);
    } else {
      late = report;
      late_frame = i;
    }
  }
  ASSERT_GE(late_frame, 0);
  i = lose_for_long(i);
  const Tracker::Outcome begun = track_alone(frames.elsewhere(0), i);
  ASSERT_TRUE(key_frame_of(begun));
  const KeyFrameMade report = mapper.process(*key_frame_of(begun), nullptr);
  tracker.key_frame_made(late);
  tracker.key_frame_made(report);
  const TrackResult result = track(frames.elsewhere(1), i + 1);
  ASSERT_EQ(result.state, TrackingState::tracking) << describe(result.reason);
  EXPECT_EQ(result.submap, shared.read()->at(report.key_frame).submap);
  EXPECT_EQ(result.pose.key_frame, report.key_frame);
  EXPECT_LT(distance(result, frames.T_cw(1)), 0.01);
}

TEST_F(SeveralMapsTest, AKeyFrameOfAnotherSubmapDoesNotBecomeTheReference) {
  for (int i = 0; i < 4; ++i) track(i);
  int i = lose_for_long(4);
  std::optional<KeyFrameRequest> withheld;
  for (int k = 0; !withheld && k < frames.count(); ++k, ++i) {
    const Tracker::Outcome outcome = track_alone(frames.elsewhere(k), i);
    if (!key_frame_of(outcome)) continue;
    if (outcome.result.method == TrackMethod::initialised) {
      tracker.key_frame_made(mapper.process(*key_frame_of(outcome), nullptr));
    } else {
      withheld = *key_frame_of(outcome);
    }
  }
  ASSERT_TRUE(withheld);
  ASSERT_EQ(shared.read()->submaps().size(), 2u);
  TrackResult result = track(frames.features(2), i);
  EXPECT_EQ(result.method, TrackMethod::recovered);
  EXPECT_EQ(result.submap, 0u);
  tracker.key_frame_made(mapper.process(*withheld, nullptr));
  for (int k = 2; k < 5; ++k) {
    result = track(frames.features(k), ++i);
    ASSERT_EQ(result.state, TrackingState::tracking) << describe(result.reason);
    EXPECT_NE(result.method, TrackMethod::recovered);
    EXPECT_EQ(result.submap, 0u);
    EXPECT_LT(distance(result, frames.T_cw(k)), 0.01);
  }
}

// Localisation where the map knows too little: depth carries the pose. The map is looked for again meanwhile, in vain;
// a submap that looks the same, with its own world, must not become the pose's.
TEST_F(TrackerTest, DeadReckoningIsLeftAsItIsByALookForTheMap) {
  for (int i = 0; i < 12; ++i) ASSERT_EQ(track(i).state, TrackingState::tracking);
  KeyFrameRequest same_place;
  same_place.frame = 100;
  same_place.features = frames.features(14);
  same_place.points.resize(static_cast<size_t>(same_place.features->size()));
  for (uint32_t i = 0; i < same_place.points.size(); ++i) {
    if (same_place.features->depth[i] > 0) same_place.new_points.push_back(i);
  }
  ASSERT_TRUE(mapper.process(same_place, nullptr).key_frame.valid());
  ASSERT_EQ(shared.read()->submaps().size(), 2u);

  TrackingSettings localize = settings;
  localize.mode = TrackingMode::localisation;
  Tracker localizer(shared, localize);
  localizer.start_lost();
  int i = 0;
  const auto follow = [&](int k) { return localizer.track(frames.features(k), i, frames.stamp(i), {}).result; };
  for (; i < 10; ++i) ASSERT_EQ(follow(i).state, TrackingState::tracking) << "frame " << i;  // for more than a second
  {  // Too few points for a pose are left, in each submap enough to be looked at.
    const auto map = shared.write();
    std::vector<std::vector<MapPointId>> points(2);
    map->for_each_point(
        [&](MapPointId id, const MapPoint& point) { points[map->at(point.reference).submap].push_back(id); });
    for (const auto& of_submap : points) {
      const size_t every = of_submap.size() / 29;
      for (size_t k = 0; k < of_submap.size(); ++k) {
        if (k % every != 0 || k / every >= 29) map->erase_point(of_submap[k]);
      }
    }
  }
  localizer.map_moved();
  int reckoned = 0;
  for (; i < 17; ++i) {
    const TrackResult result = follow(i);
    ASSERT_EQ(result.state, TrackingState::tracking) << "frame " << i << ": " << describe(result.reason);
    reckoned += result.method == TrackMethod::dead_reckoned;
    EXPECT_EQ(result.submap, 0u) << "frame " << i;
    EXPECT_LT(distance(result, frames.T_cw(i)), 0.03) << "frame " << i;
  }
  EXPECT_GE(reckoned, 5) << "the map is looked for at the fifth";

  // Where mapping begins, the camera is to be found in the map first.
  localizer.set_mode(TrackingMode::mapping);
  for (; i < 20; ++i) {
    const Tracker::Outcome outcome = localizer.track(frames.features(i), i, frames.stamp(i), {});
    EXPECT_EQ(outcome.result.state, TrackingState::lost) << "frame " << i;
    EXPECT_EQ(outcome.result.reason, NoPoseReason::no_key_frame_matches);
    EXPECT_TRUE(std::holds_alternative<std::monostate>(outcome.request));
  }
}

TEST_F(TrackerTest, NothingIsAskedOfMappingWhileItIsSwitchedOff) {
  int i = 0;
  for (; i < 6; ++i) ASSERT_EQ(track(i).state, TrackingState::tracking);
  tracker.set_mode(TrackingMode::localisation);
  tracker.set_mode(TrackingMode::localisation);  // again, which changes nothing
  for (; i < 20; ++i) {
    const Tracker::Outcome outcome = track_alone(frames.features(i), i);
    EXPECT_TRUE(std::holds_alternative<std::monostate>(outcome.request)) << "frame " << i;
    if (outcome.result.method == TrackMethod::dead_reckoned) break;
    EXPECT_EQ(outcome.result.state, TrackingState::tracking) << "frame " << i;
  }
  EXPECT_GT(i, 6);
  const size_t before = shared.read()->key_frame_count();
  tracker.set_mode(TrackingMode::mapping);
  for (int k = 5; k >= 0; --k) track(frames.features(k), ++i);  // back to where the map is
  for (int k = 0; k < 20; ++k) track(frames.features(k), ++i);
  EXPECT_EQ(tracker.state(), TrackingState::tracking);
  EXPECT_GT(shared.read()->key_frame_count(), before);
  EXPECT_EQ(shared.read()->submaps().size(), 1u);
}

TEST_F(TrackerTest, WithoutAMapLocalisationIsLostAndMappingBeginsOne) {
  tracker.set_mode(TrackingMode::localisation);
  EXPECT_EQ(track(0).state, TrackingState::lost);
  EXPECT_EQ(track(1).reason, NoPoseReason::no_key_frame_matches);
  tracker.set_mode(TrackingMode::mapping);
  EXPECT_EQ(tracker.state(), TrackingState::not_initialised);
  EXPECT_EQ(track(2).state, TrackingState::tracking);
}

// Lost in localisation only, a young map is neither given up nor replaced; it is when mapping goes on.
TEST_F(MonocularTrackerTest, AYoungMapIsKeptWhileMappingIsSwitchedOff) {
  int i = 0;
  while (tracker.state() == TrackingState::not_initialised && i < 30) track(i), ++i;
  ASSERT_EQ(tracker.state(), TrackingState::tracking);
  tracker.set_mode(TrackingMode::localisation);
  for (int k = 0; k < 40; ++k) {
    const Tracker::Outcome outcome = track_alone(frames.blank(), ++i);
    EXPECT_EQ(outcome.result.state, TrackingState::lost);
    EXPECT_FALSE(outcome.discard_submap);
    EXPECT_TRUE(std::holds_alternative<std::monostate>(outcome.request));
  }
  EXPECT_EQ(shared.read()->submaps().size(), 1u);
}

}  // namespace
}  // namespace covis
