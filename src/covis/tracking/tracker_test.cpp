// SPDX-License-Identifier: Apache-2.0
// The tracker with the mapper called in turn: no threads.
#include "covis/tracking/tracker.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>

#include "covis/features/test_features.h"
#include "covis/tracking/test_tracker.h"

namespace covis {
namespace {

using testing::HasSubstr;

TEST_F(TrackerTest, FollowsTheTruth) {
  for (int i = 0; i < frames.count(); ++i) {
    const TrackResult result = track(i);
    ASSERT_EQ(result.state, TrackingState::tracking) << "frame " << i << ": " << describe(result.reason);
    if (i == 0) {
      EXPECT_EQ(result.method, TrackMethod::initialised);
      continue;
    }
    EXPECT_LT((result.T_cw.inverse().t() - frames.T_cw(i).inverse().t()).norm(), 0.01) << "frame " << i;
    EXPECT_GE(result.inliers, settings.options.local_map.min_inliers);
    EXPECT_LE(result.inliers, result.features);
    EXPECT_LE(result.local_in_view, result.local_points);
    // The pose relative to its reference is the same.
    const SE3 by_reference = result.pose.T_cw(*shared.read());
    EXPECT_LT((by_reference.t() - result.T_cw.t()).norm(), 0.02);
  }
}

// Every second frame, then one left out, then two more: numbers with gaps, as whoever calls may give them.
TEST_F(TrackerTest, FramesLeftOutDoNotEndTheMotionModel) {
  for (const int i : {0, 2, 4, 6, 9, 10, 11}) {
    const TrackResult result = track(i);
    ASSERT_EQ(result.state, TrackingState::tracking) << "frame " << i << ": " << describe(result.reason);
    if (i < 4) continue;
    EXPECT_EQ(result.method, TrackMethod::motion_model) << "frame " << i;
    EXPECT_LT((result.T_cw.inverse().t() - frames.T_cw(i).inverse().t()).norm(), 0.01) << "frame " << i;
  }
}

TEST_F(TrackerTest, AfterAPauseNoMotionIsExpected) {
  for (int i = 0; i < 6; ++i) ASSERT_EQ(track(i).state, TrackingState::tracking);
  const auto later = tracker.track(frames.features(6), 6, frames.stamp(5) + from_seconds(10.0), {}).result;
  ASSERT_EQ(later.state, TrackingState::tracking) << describe(later.reason);
  EXPECT_EQ(later.method, TrackMethod::reference_key_frame);
  EXPECT_LT((later.T_cw.inverse().t() - frames.T_cw(6).inverse().t()).norm(), 0.01);
}

// A camera of 5 % more focal length sees the same from 5 % farther away; its depths, which are measured without the
// focal length, hold it a little.
TEST_F(TrackerTest, TheFirstFrameAfterARefinementIsTrackedByTheRefinedCamera) {
  for (int i = 0; i < 6; ++i) ASSERT_EQ(track(i).state, TrackingState::tracking);
  Pinhole longer = frames.camera();
  for (double* value : {&longer.fx, &longer.fy, &longer.bf}) *value *= 1.05;
  shared.write()->set_camera(longer);
  tracker.map_moved();
  const TrackResult result = track(6);
  ASSERT_EQ(result.state, TrackingState::tracking) << describe(result.reason);
  double depth = 0;
  int points = 0;
  shared.read()->for_each_point([&](MapPointId, const MapPoint& p) {
    depth += (frames.T_cw(6) * p.position_w).z();
    ++points;
  });
  const double back = (result.T_cw * frames.T_cw(6).inverse()).t().z();
  EXPECT_NEAR(back / (0.05 * depth / points), 0.9, 0.4);
}

// The features of a frame with its depths changed.
FeaturesPtr with_depths(const Features& features, float factor) {
  auto other = std::make_shared<Features>(features);
  for (float& depth : other->depth) depth *= factor;
  return other;
}

TEST_F(TrackerTest, DepthThatContradictsTheMapIsNotUsed) {
  int key_frames = 0;
  for (int i = 0; i < frames.count(); ++i) {
    const bool wrong = i >= 8 && i < 16;
    const TrackResult result = track(wrong ? with_depths(*frames.features(i), 1.5f) : frames.features(i), i);
    ASSERT_EQ(result.state, TrackingState::tracking) << "frame " << i << ": " << describe(result.reason);
    const bool doubted = i >= 8 && i < 16 + 2;  // until three frames agree
    EXPECT_EQ(result.doubts.depth_contradiction > 0, doubted) << "frame " << i;
    EXPECT_EQ(result.tentative, doubted) << "frame " << i;
    if (wrong) {
      EXPECT_NEAR(result.doubts.depth_contradiction, std::log(1.5), 0.05) << "frame " << i;
    }
    EXPECT_LT((result.T_cw.inverse().t() - frames.T_cw(i).inverse().t()).norm(), 0.015) << "frame " << i;
    key_frames += doubted && result.key_frame;
  }
  EXPECT_GT(key_frames, 0) << "the map grows meanwhile, by images alone";
  const auto map = shared.read();
  for (const KeyFrameId id : map->key_frames()) {
    const Features& features = *map->at(id).features;
    const bool has_depth = std::any_of(features.depth.begin(), features.depth.end(), [](float z) { return z > 0; });
    const int64_t frame = map->at(id).frame;
    EXPECT_EQ(has_depth, frame < 8 || frame > 16 + 2) << "frame " << frame;
  }
}

// The lower half of an image a third of its width off.
FeaturesPtr torn(const Features& features) {
  auto other = std::make_shared<Features>(features);
  for (size_t i = 0; i < other->x.size(); ++i) {
    if (other->y[i] > 120) other->x[i] += 107;
  }
  return other;
}

TEST_F(TrackerTest, TornImagesAreTrackedAndNotMapped) {
  ptrdiff_t before = 0;  // points that the last frame had by the depth of frames, not of the map
  for (int i = 0; i < frames.count(); ++i) {
    const bool is_torn = i >= 8 && i < 14;
    const TrackResult result = track(is_torn ? torn(*frames.features(i)) : frames.features(i), i);
    ASSERT_EQ(result.state, TrackingState::tracking) << "frame " << i << ": " << describe(result.reason);
    EXPECT_EQ(result.tentative, result.doubts.torn) << "frame " << i;
    const bool may_go_on = i == 14 || i == 15;  // for all that is known
    EXPECT_TRUE(result.doubts.torn == is_torn || may_go_on) << "frame " << i;
    EXPECT_FALSE(is_torn && result.key_frame) << "frame " << i;
    const auto& source = tracker.last_frame().source;
    const auto from_depth = std::count(source.begin(), source.end(), PointSource::depth);
    if (i > 8 && i <= 14) {
      EXPECT_LE(from_depth, before) << "frame " << i << ": the depth of a torn frame makes no points";
    }
    before = from_depth;
    EXPECT_LT((result.T_cw.inverse().t() - frames.T_cw(i).inverse().t()).norm(), 0.02) << "frame " << i;
  }
}

class TurningTest : public TrackerTest, public testing::WithParamInterface<double> {
 protected:
  TurningTest() : TrackerTest(by_turn_alone()) {}

  static TrackingSettings by_turn_alone() {
    TrackingSettings settings = settings_of(Sensor::rgbd);
    settings.options.key_frame.key_frame_ratio = 0;
    settings.options.key_frame.min_close_points = 0;
    settings.options.key_frame.key_frame_turn = GetParam();
    return settings;
  }
};

// The second is more than any turn can be, though its cosine is not.
INSTANTIATE_TEST_SUITE_P(Shares, TurningTest, testing::Values(0.05, 5.5));

TEST_P(TurningTest, AKeyFrameIsDueWhereTheViewHasTurnedAwayFromItsReference) {
  const double view = 2 * std::atan(160 / frames.camera().fx);  // images are 320 wide
  int due = 0;
  track(0);
  for (int i = 1; i < frames.count(); ++i) {
    const TrackResult result = track(i);
    ASSERT_EQ(result.state, TrackingState::tracking) << "frame " << i << ": " << describe(result.reason);
    const double turned = std::acos(result.pose.T_cr.R()(2, 2));
    EXPECT_EQ(result.key_frame, turned > GetParam() * view) << "frame " << i << ": " << turned;
    due += result.key_frame;
  }
  EXPECT_EQ(due >= 2, GetParam() < 1) << due;
}

TEST_P(TurningTest, ATornImageDoesNotTellThatItsPointsAreNotFound) {
  uint32_t frames_counted = 0;  // since the last key frame
  int due_after = 0;
  for (int i = 0; i < frames.count(); ++i) {
    const bool is_torn = i >= 4 && i < 10;
    const Tracker::Outcome outcome = track_alone(is_torn ? torn(*frames.features(i)) : frames.features(i), i);
    frames_counted += !outcome.result.doubts.torn;
    if (const KeyFrameRequest* key_frame = key_frame_of(outcome)) {
      for (const PointCount& count : key_frame->counts) EXPECT_LE(count.visible, frames_counted) << "frame " << i;
      frames_counted = 0;
      due_after += i > 10;
    }
    do_mapping(outcome);
  }
  EXPECT_EQ(due_after >= 1, GetParam() < 1) << due_after;
}

class NewPointsTest : public TrackerTest, public testing::WithParamInterface<double> {
 protected:
  NewPointsTest() : TrackerTest(by_new_points_alone()) {}

  static TrackingSettings by_new_points_alone() {
    TrackingSettings settings = settings_of(Sensor::monocular);
    settings.options.key_frame.key_frame_ratio_mono = 0;
    settings.options.key_frame.key_frame_all_ratio_mono = GetParam();
    settings.options.key_frame.key_frame_parallax_mono = 10;
    return settings;
  }
};

INSTANTIATE_TEST_SUITE_P(Shares, NewPointsTest, testing::Values(0.0, 0.8));

TEST_P(NewPointsTest, AKeyFrameIsDueWhereTooFewOfAllPointsOfTheReferenceAreLeft) {
  int due = 0;
  for (int i = 0; i < frames.count(); ++i) {
    const Tracker::Outcome outcome = track_alone(frames.features(i), i);
    const TrackResult& result = outcome.result;
    if (result.state == TrackingState::tracking && result.method != TrackMethod::initialised) {
      const int all = shared.read()->tracked_points(result.pose.key_frame, 2);
      EXPECT_EQ(result.key_frame, result.inliers < GetParam() * all) << "frame " << i;
      due += result.key_frame;
    }
    do_mapping(outcome);
  }
  ASSERT_EQ(tracker.state(), TrackingState::tracking);
  EXPECT_EQ(due >= 2, GetParam() > 0) << due;
}

TEST_F(TrackerTest, NothingToSeeIsNoFirstKeyFrame) {
  const TrackResult result = track_blank(0);
  EXPECT_EQ(result.state, TrackingState::not_initialised);
  EXPECT_EQ(result.reason, NoPoseReason::few_features);
  EXPECT_EQ(shared.read()->key_frame_count(), 0u);
  EXPECT_EQ(track(1).state, TrackingState::tracking) << "the next one may be";
}

TEST_F(TrackerTest, FeaturesWithoutDepthAreNoFirstKeyFrame) {
  Features flat = *frames.features(0);
  std::fill(flat.depth.begin(), flat.depth.end(), 0.0f);
  std::fill(flat.u_right.begin(), flat.u_right.end(), -1.0f);
  const TrackResult result = track(std::make_shared<Features>(flat), 0);
  EXPECT_EQ(result.state, TrackingState::not_initialised);
  EXPECT_EQ(result.reason, NoPoseReason::few_features_with_depth);
}

TEST_F(TrackerTest, LossKeepsTheMapSaysWhyAndEndsWhenAKnownViewComes) {
  for (int i = 0; i < 6; ++i) ASSERT_EQ(track(i).state, TrackingState::tracking);
  EXPECT_FALSE(tracker.wants_more_features());
  EXPECT_FALSE(tracker.near_loss());
  const size_t points = shared.read()->point_count();
  for (int i = 6; i < 9; ++i) {
    const TrackResult lost = track_blank(i);
    EXPECT_EQ(lost.state, TrackingState::lost);
    EXPECT_THAT(std::string(describe(lost.reason)), HasSubstr("matches"));
    EXPECT_EQ(lost.inliers, 0);
    EXPECT_FALSE(lost.key_frame);
  }
  EXPECT_TRUE(tracker.wants_more_features());
  EXPECT_TRUE(tracker.near_loss());
  EXPECT_EQ(shared.read()->point_count(), points);
  const TrackResult found = track(frames.features(5), 9);
  EXPECT_EQ(found.state, TrackingState::tracking);
  EXPECT_EQ(found.method, TrackMethod::recovered);
  EXPECT_GE(found.inliers, settings.options.recovery.min_inliers_recovered);
  EXPECT_LT((found.T_cw.inverse().t() - frames.T_cw(5).inverse().t()).norm(), 0.01);
}

TEST_F(TrackerTest, AJumpOfTheCameraIsSurvivedByTheReferenceKeyFrame) {
  for (int i = 0; i < 6; ++i) track(i);
  const TrackResult jumped = track(frames.features(0), 6);
  ASSERT_EQ(jumped.state, TrackingState::tracking) << describe(jumped.reason);
  EXPECT_LT((jumped.T_cw.inverse().t() - frames.T_cw(0).inverse().t()).norm(), 0.01);
}

TEST_F(MonocularTrackerTest, SaysWhatItWaitsFor) {
  EXPECT_EQ(track_blank(0).reason, NoPoseReason::few_features);
  EXPECT_TRUE(tracker.wants_more_features());
  const TrackResult still = track(frames.features(0), 1);
  EXPECT_EQ(still.state, TrackingState::not_initialised);
  EXPECT_EQ(track(frames.features(0), 2).reason, NoPoseReason::low_parallax) << "the same view twice";
  EXPECT_EQ(shared.read()->key_frame_count(), 0u);
}

TEST_F(MonocularTrackerTest, FramesBeforeTheMapWaitUntilItWillStay) {
  int begun = 0;
  while (begun < frames.count() && track(begun).state != TrackingState::tracking) ++begun;
  ASSERT_GT(begun, 0);
  for (int i = begun + 1; i < frames.count(); ++i) {
    const size_t key_frames = shared.read()->key_frame_count();
    const Tracker::Outcome outcome = track_alone(frames.features(i), i);
    do_mapping(outcome);
    const KeyFrameRequest* request = key_frame_of(outcome);
    if (!request) continue;
    ASSERT_EQ(request->unlocated.empty(), key_frames <= 5) << "a map of five may be given up";
    if (key_frames <= 5) continue;
    ASSERT_EQ(request->unlocated.size(), static_cast<size_t>(begun) + 1);
    EXPECT_EQ(request->unlocated.front().frame, begun);
    EXPECT_EQ(request->unlocated.back().frame, 0);
    EXPECT_TRUE(shared.read()->find(request->unlocated.back().near));
    return;
  }
  FAIL() << "no key frame was asked for";
}

// The last frame shows a patch alone, and that has moved aside: the first pose follows it, away from all else that is
// known.
TEST_F(MonocularTrackerTest, AFirstPoseThatIsAstrayIsSoughtAgainFromThePrediction) {
  constexpr int kPatchAlone = 14;
  constexpr float kAside = 14, kHalfPatch = 60;  // pixels
  for (int i = 0; i < kPatchAlone; ++i) track(i);
  const SE3 before = tracker.last_frame().T_cw;
  const auto in_patch = [&](const Features& f, size_t i) {
    const auto off_centre = [](float at, double centre) { return std::abs(at - static_cast<float>(centre)); };
    return std::max(off_centre(f.x[i], frames.camera().cx), off_centre(f.y[i], frames.camera().cy)) < kHalfPatch;
  };
  Features patch = *frames.features(kPatchAlone);
  for (size_t i = 0; i < patch.x.size(); ++i) {
    if (!in_patch(patch, i)) patch.descriptor[i] = frames.elsewhere(kPatchAlone)->descriptor[i];
  }
  ASSERT_EQ(track_alone(std::make_shared<Features>(patch), kPatchAlone).result.state, TrackingState::tracking);
  const int of_patch = tracker.last_frame().matches();
  Features aside = *frames.features(kPatchAlone + 1);
  for (size_t i = 0; i < aside.x.size(); ++i) {
    if (in_patch(aside, i)) aside.x[i] += kAside;
  }
  finish(aside);
  const TrackResult result = track_alone(std::make_shared<Features>(aside), kPatchAlone + 1).result;
  ASSERT_EQ(result.state, TrackingState::tracking);
  EXPECT_EQ(result.method, TrackMethod::motion_model);
  EXPECT_GT(result.inliers, of_patch);
  const Eigen::Matrix3d turn = (result.T_cw * before.inverse()).R();
  const Eigen::Matrix3d truth = (frames.T_cw(kPatchAlone + 1) * frames.T_cw(kPatchAlone - 1).inverse()).R();
  EXPECT_LT(Eigen::AngleAxisd(turn * truth.transpose()).angle(), 0.01);
}

TEST_F(MonocularTrackerTest, AYoungMapThatIsLostIsGivenUp) {
  int i = 0;
  while (i < frames.count() - 1 && track(i).state != TrackingState::tracking) ++i;
  ASSERT_EQ(tracker.state(), TrackingState::tracking);
  ASSERT_GE(shared.read()->key_frame_count(), 2u);
  EXPECT_FALSE(tracker.take_unlocated().empty());
  track_blank(i + 1);
  EXPECT_TRUE(tracker.take_unlocated().empty()) << "where the camera was found may not hold";
  ++i;
  const int first_lost = ++i;
  TrackResult last;
  for (; i < first_lost + 16; ++i) last = track(frames.blank(), i);
  EXPECT_EQ(last.state, TrackingState::not_initialised);
  EXPECT_EQ(shared.read()->key_frame_count(), 0u);
}

TEST_F(MonocularTrackerTest, AYoungMapThatIsLostIsReplacedAsSoonAsAnotherCanBegin) {
  int begun = 0;
  while (begun < frames.count() / 2 && track(begun).state != TrackingState::tracking) ++begun;
  int away = begun + 1;  // the first frame in another place
  TrackResult last = track(away++);
  while (last.key_frame) last = track(away++);
  ASSERT_EQ(last.state, TrackingState::tracking) << "its points are counted, and no key frame took the counts";
  const uint32_t first = shared.read()->submaps().front().id;
  for (int i = 0; i <= begun; ++i) last = track(frames.elsewhere(i), away + i);
  EXPECT_EQ(last.state, TrackingState::tracking) << describe(last.reason);
  ASSERT_EQ(shared.read()->submaps().size(), 1u);
  EXPECT_NE(shared.read()->submaps().front().id, first);
  EXPECT_EQ(shared.read()->check(), "");
  bool asked = false;
  for (int i = begun + 1; !asked && away + i < frames.count(); ++i) {
    const Tracker::Outcome outcome = track_alone(frames.elsewhere(i), away + i);
    const KeyFrameRequest* request = key_frame_of(outcome);
    if (!request) continue;
    asked = true;
    for (const PointCount& count : request->counts)
      EXPECT_TRUE(shared.read()->find(count.point)) << "of the map that is gone";
  }
  EXPECT_TRUE(asked);
}

TEST_F(MonocularTrackerTest, AllBeginsAnewWhereWhatReplacesAYoungMapDoesNotHold) {
  int begun = 0;
  while (begun < frames.count() / 2 && track(begun).state != TrackingState::tracking) ++begun;
  ASSERT_EQ(tracker.state(), TrackingState::tracking);
  int next = 0;  // the first frame after the replacement
  bool replaced = false;
  for (; !replaced && next < frames.count(); ++next) {
    const Tracker::Outcome outcome = track_alone(frames.elsewhere(next), begun + 1 + next);
    if (!outcome.discard_submap) continue;
    ASSERT_EQ(outcome.result.method, TrackMethod::initialised) << "it is given up, not replaced";
    shared.write()->erase_submap(*outcome.discard_submap);
    tracker.key_frame_made({.frame = begun + 1 + next});
    replaced = true;
  }
  ASSERT_TRUE(replaced);
  EXPECT_EQ(tracker.state(), TrackingState::not_initialised);
  EXPECT_EQ(track(frames.elsewhere(next), begun + 1 + next).reason, NoPoseReason::waiting_for_parallax);
}

}  // namespace
}  // namespace covis
