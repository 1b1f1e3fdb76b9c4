// SPDX-License-Identifier: Apache-2.0
#include "covis/tracking/key_frame_policy.h"

#include <gmock/gmock.h>

#include <cmath>

#include "covis/tracking/test_frame.h"

namespace covis {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

constexpr auto kIdle = MappingLoad::idle;
constexpr auto kBusy = MappingLoad::busy;

class KeyFramePolicyTest : public testing::Test {
 protected:
  KeyFramePolicyTest() {
    // None is due by any criterion: each test makes one of them hold.
    options.min_close_points = 0;
    local_map.reference_points = local_map.reference_all_points = 100;
    world.add_key_frames(1);
    match_points(frame, view, world);
  }

  bool is_due(Sensor sensor, int inliers = 100, MappingLoad load = kIdle,
              Schedule schedule = Schedule::deterministic) const {
    return KeyFramePolicy(sensor, options, schedule).is_due(frame, inliers, local_map, scene.camera, load);
  }
  static std::shared_ptr<Features> copy(const TrackedFrame& frame) {
    return std::make_shared<Features>(*frame.features);
  }

  const PointScene scene = PointScene::wall();
  SceneMap world{scene};
  const PointScene::View view = scene.view(scene.T_cw(0));
  TrackedFrame frame = frame_of(view, SE3());
  LocalMap local_map;
  KeyFrameOptions options;
};

TEST_F(KeyFramePolicyTest, NoneIsDueWhileAllIsWell) {
  for (const Sensor sensor : {Sensor::monocular, Sensor::stereo, Sensor::rgbd}) EXPECT_FALSE(is_due(sensor));
}

TEST_F(KeyFramePolicyTest, OneIsDueWhereTooFewPointsOfTheReferenceAreLeft) {
  for (const Sensor sensor : {Sensor::stereo, Sensor::rgbd}) {
    EXPECT_FALSE(is_due(sensor, 75));
    EXPECT_TRUE(is_due(sensor, 74));
  }
  EXPECT_FALSE(is_due(Sensor::monocular, 80));
  EXPECT_TRUE(is_due(Sensor::monocular, 79)) << "its share is another";
}

TEST_F(KeyFramePolicyTest, MonocularAlsoWhereHalfOfAllItsPointsAreGone) {
  local_map.reference_all_points = 200;
  EXPECT_FALSE(is_due(Sensor::monocular, 100));
  EXPECT_TRUE(is_due(Sensor::monocular, 99));
  EXPECT_FALSE(is_due(Sensor::stereo, 99));
}

TEST_F(KeyFramePolicyTest, MonocularAlsoWhereTheCameraHasMovedFarForTheDepthOfItsPoints) {
  double inverse_squares = 0;
  int points = 0;
  for (size_t i = 0; i < frame.source.size(); ++i) {
    if (!frame.on_map(i)) continue;
    inverse_squares += std::pow((frame.T_cw * frame.positions[i]).z(), -2);
    ++points;
  }
  ASSERT_GT(points, 0);
  const double depth = std::sqrt(points / inverse_squares);
  const auto moved = [&](double share) {
    const Eigen::Vector3d baseline = share * depth * Eigen::Vector3d(0, 0.8, 0.6);
    local_map.reference.T_cw = SE3(so3_exp({0.2, 0, 0}), baseline) * frame.T_cw;
  };
  moved(0.119);
  EXPECT_FALSE(is_due(Sensor::monocular));
  moved(0.121);
  EXPECT_TRUE(is_due(Sensor::monocular));
  EXPECT_FALSE(is_due(Sensor::rgbd)) << "depth tells the translation from one frame";
}

TEST_F(KeyFramePolicyTest, NoneIsMadeOfTooFewPoints) {
  options.key_frame_min_inliers = 15;
  EXPECT_TRUE(is_due(Sensor::rgbd, 15));
  EXPECT_FALSE(is_due(Sensor::rgbd, 14));
  EXPECT_FALSE(is_due(Sensor::monocular, 14));
}

TEST_F(KeyFramePolicyTest, OneIsDueWhereFewClosePointsAreTrackedAndManyCouldBe) {
  options.close_depth.baselines = 60;  // a baseline is 0.1 metres
  const auto close = [&](size_t i) { return frame.features->depth[i] <= 6; };
  for (size_t i = 0; i < frame.source.size(); ++i) {
    if (close(i) && i % 2 == 0) frame.drop_match(i);
  }
  int tracked = 0, untracked = 0;
  for (size_t i = 0; i < frame.source.size(); ++i) {
    if (close(i)) ++(frame.on_map(i) ? tracked : untracked);
  }
  options.min_close_points = tracked + 1;
  options.new_close_points = untracked - 1;
  EXPECT_TRUE(is_due(Sensor::rgbd));
  EXPECT_TRUE(is_due(Sensor::stereo));
  EXPECT_FALSE(is_due(Sensor::monocular)) << "depth is not asked for there";
  options.min_close_points = tracked;
  EXPECT_FALSE(is_due(Sensor::rgbd)) << "enough are tracked";
  options.min_close_points = tracked + 1;
  options.new_close_points = untracked;
  EXPECT_FALSE(is_due(Sensor::rgbd)) << "too few would be won";
}

TEST_F(KeyFramePolicyTest, OneIsDueWhereTheViewHasTurnedAway) {
  // The wider angle of view: 2 atan(320 / 500) = 65.2 degrees, a fifth of which is 13.
  const auto turned = [&](double degrees) {
    local_map.reference.T_cw = SE3(so3_exp({0.1, 0, 0}), {1, 2, 3});
    frame.T_cw = SE3(so3_exp({0, degrees / 57.29578, 0}), {}) * local_map.reference.T_cw;
  };
  for (const double sign : {-1.0, 1.0}) {
    turned(sign * 12.9);
    EXPECT_FALSE(is_due(Sensor::rgbd));
    turned(sign * 13.2);
    EXPECT_TRUE(is_due(Sensor::rgbd));
    EXPECT_FALSE(is_due(Sensor::monocular)) << "a turn alone gives no parallax";
  }
  frame.T_cw = SE3(so3_exp({0, 0, 2}), {}) * local_map.reference.T_cw;
  EXPECT_FALSE(is_due(Sensor::rgbd)) << "about its own axis it sees the same";
}

TEST_F(KeyFramePolicyTest, MoreThanAnyTurnIsNeverDue) {
  options.key_frame_turn = 5.5;  // 358 degrees
  frame.T_cw = SE3(so3_exp({0, 1, 0}), {});
  EXPECT_FALSE(is_due(Sensor::rgbd));
}

TEST_F(KeyFramePolicyTest, BusyMappingIsNotAskedForMore) {
  for (const Sensor sensor : {Sensor::monocular, Sensor::rgbd}) {
    EXPECT_TRUE(is_due(sensor, 50, kIdle));
    EXPECT_FALSE(is_due(sensor, 50, kBusy));
  }
}

TEST_F(KeyFramePolicyTest, InRealTimeOneMayBeMadeAfterAWhileThoughMappingIsBusy) {
  KeyFramePolicy policy(Sensor::rgbd, options, Schedule::realtime);
  policy.begin(from_seconds(10));
  frame.stamp = from_seconds(11);
  EXPECT_FALSE(policy.is_due(frame, 50, local_map, scene.camera, kBusy));
  frame.stamp = from_seconds(11.01);
  EXPECT_TRUE(policy.is_due(frame, 50, local_map, scene.camera, kBusy));
  EXPECT_FALSE(policy.is_due(frame, 100, local_map, scene.camera, kBusy)) << "it must be due all the same";
  policy.request(frame, {}, scene.camera);
  EXPECT_FALSE(policy.is_due(frame, 50, local_map, scene.camera, kBusy)) << "the while counts from the last one";
}

TEST_F(KeyFramePolicyTest, WaitingLongHelpsNotWhereResultsMustNotDependOnTime) {
  frame.stamp = from_seconds(100);
  EXPECT_FALSE(is_due(Sensor::rgbd, 50, kBusy, Schedule::deterministic));
  EXPECT_TRUE(is_due(Sensor::rgbd, 50, kBusy, Schedule::realtime));
}

TEST_F(KeyFramePolicyTest, InRealTimeFewClosePointsDoNotWaitForMapping) {
  frame.clear_matches();
  options.close_depth.baselines = 80;
  options.min_close_points = 100;
  EXPECT_TRUE(is_due(Sensor::rgbd, 100, kBusy, Schedule::realtime));
  EXPECT_FALSE(is_due(Sensor::rgbd, 100, kBusy, Schedule::deterministic));
}

TEST_F(KeyFramePolicyTest, WhatMovesMakesNoPointsAndAsksForNone) {
  frame.clear_matches();
  options.close_depth.baselines = 80;
  options.min_close_points = 100;
  EXPECT_TRUE(is_due(Sensor::rgbd));
  KeyFramePolicy policy(Sensor::rgbd, options, Schedule::deterministic);
  const std::vector<uint32_t> all = policy.request(frame, {}, scene.camera).new_points;
  ASSERT_GT(all.size(), 100u);
  frame.moved[all[3]] = frame.stamp;
  EXPECT_EQ(policy.request(frame, {}, scene.camera).new_points.size(), all.size() - 1);
  for (Timestamp& moved : frame.moved) moved = frame.stamp;
  EXPECT_FALSE(is_due(Sensor::rgbd));
}

TEST_F(KeyFramePolicyTest, TheRequestHoldsTheFrameAndItsMatches) {
  frame.index = 12;
  frame.stamp = 345;
  frame.set_match(3, {}, {0, 0, 1}, PointSource::depth);
  frame.drop_match(4);
  const RelativePose pose{world.frames[0], 1, SE3(Eigen::Matrix3d::Identity(), {1, 2, 3})};
  const KeyFrameRequest request =
      KeyFramePolicy(Sensor::rgbd, options, Schedule::deterministic).request(frame, pose, scene.camera);
  EXPECT_EQ(request.frame, 12);
  EXPECT_EQ(request.stamp, 345);
  EXPECT_EQ(request.features, frame.features);
  EXPECT_EQ(request.pose.key_frame, world.frames[0]);
  EXPECT_EQ(request.pose.T_cr.t(), pose.T_cr.t());
  ASSERT_EQ(request.points.size(), frame.points.size());
  for (size_t i = 0; i < request.points.size(); ++i) {
    EXPECT_EQ(request.points[i], i == 3 || i == 4 ? MapPointId{} : frame.points[i]);
  }
}

TEST_F(KeyFramePolicyTest, TheRequestsNewPointsAreThoseNearByDepth) {
  auto features = copy(frame);
  for (float& depth : features->depth) depth = 0;
  features->depth[5] = 3;
  features->depth[9] = 1;
  features->depth[7] = 2;
  features->depth[2] = 2;
  features->depth[8] = 30;  // not close
  features->depth[6] = 1.5;
  frame.start(features, 0, 0);
  frame.set_match(6, world.handles[0], {}, PointSource::map);
  KeyFramePolicy policy(Sensor::rgbd, options, Schedule::deterministic);
  EXPECT_THAT(policy.request(frame, {}, scene.camera).new_points, ElementsAre(9, 2, 7, 5)) << "6 has a point";
  options.min_close_points = 6;
  KeyFramePolicy content(Sensor::rgbd, options, Schedule::deterministic);
  EXPECT_THAT(content.request(frame, {}, scene.camera).new_points, ElementsAre(9, 2, 7, 5, 8));
  KeyFramePolicy monocular(Sensor::monocular, options, Schedule::deterministic);
  EXPECT_THAT(monocular.request(frame, {}, scene.camera).new_points, IsEmpty());
}

TEST_F(KeyFramePolicyTest, TheRequestHoldsTheCountsSinceTheLast) {
  KeyFramePolicy policy(Sensor::rgbd, options, Schedule::deterministic);
  frame.clear_matches();
  frame.set_match(0, {4, 0}, {}, PointSource::map);
  local_map.points.id = {{4, 0}, {5, 0}};
  policy.count(frame, local_map, {1, 1});
  policy.count(frame, local_map, {1, 0});
  const KeyFrameRequest request = policy.request(frame, {}, scene.camera);
  ASSERT_EQ(request.counts.size(), 2u);
  EXPECT_EQ(request.counts[0].point, (MapPointId{4, 0}));
  EXPECT_EQ(request.counts[0].visible, 2u);
  EXPECT_EQ(request.counts[0].found, 2u);
  EXPECT_EQ(request.counts[1].visible, 1u);
  EXPECT_THAT(policy.request(frame, {}, scene.camera).counts, IsEmpty());
  policy.count(frame, local_map, {1, 1});
  policy.clear_counts();
  EXPECT_THAT(policy.request(frame, {}, scene.camera).counts, IsEmpty());
}

TEST_F(KeyFramePolicyTest, ClosenessIsMeasuredInBaselines) {
  const KeyFramePolicy policy(Sensor::stereo, options, Schedule::deterministic);
  EXPECT_DOUBLE_EQ(policy.close_depth(scene.camera), 40 * 0.1);
}

}  // namespace
}  // namespace covis
