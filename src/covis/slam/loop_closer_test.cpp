// SPDX-License-Identifier: Apache-2.0
#include "covis/slam/loop_closer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <iterator>

#include "covis/slam/test_tracker.h"

namespace covis {
namespace {

// A desk looked at all the time, of which the last key frame shares nothing any more with an earlier one itself, and is
// off its place a little.
class LoopCloserTest : public TrackerTest {
 protected:
  LoopCloserTest() : TrackerTest(many_key_frames(), vocabulary()) {}

  static SystemOptions many_key_frames() {
    SystemOptions options = options_of(Sensor::rgbd);
    options.tracker.key_frame.key_frame_turn = 0.01;
    options.mapper.cull_redundancy = 1;
    return options;
  }

  void SetUp() override {
    for (int i = 0; i < frames.count(); ++i) ASSERT_EQ(track(i).state, TrackState::tracking);
    const std::vector<KeyFrameId> all = shared.read()->key_frames();
    ASSERT_GT(all.size(), 14u);
    last = all.back();
    place = all[all.size() - 12];
    const auto map = shared.write();
    for (const MapPointId id : points_of(*map, last)) map->erase_observation(id, place);
    ASSERT_TRUE(map->find(place));
    map->set_pose(last, SE3(Eigen::Matrix3d::Identity(), {0.02, 0, 0}) * map->at(last).T_cw);
  }
  static std::vector<MapPointId> points_of(const Map& map, KeyFrameId id) {
    std::vector<MapPointId> points;
    std::copy_if(map.at(id).points.begin(), map.at(id).points.end(), std::back_inserter(points),
                 [](MapPointId point) { return point.valid(); });
    return points;
  }

  KeyFrameId last, place;
};

TEST_F(LoopCloserTest, WhatTheKeyFrameSharesWithThePlaceAlreadyIsNoLoop) {
  LoopReport report;
  LoopCloser closer(shared, options);
  EXPECT_FALSE(closer.process(last, report));
  EXPECT_GE(report.found_again, options.loop.min_found) << "it was not refused for anything else";
}

TEST_F(LoopCloserTest, ThePlaceSeenAgainInOtherPointsIsALoop) {
  {
    const auto map = shared.write();
    const std::vector<MapPointId> points = map->at(last).points;
    for (uint32_t i = 0; i < points.size(); ++i) {
      if (!points[i].valid() || i % 4 == 0) continue;  // what is left makes key frames beside it its neighbours
      const Eigen::Vector3d position = map->at(points[i]).position_w;
      map->erase_observation(points[i], last);
      map->add_point(position, last, i);
    }
  }
  LoopReport report;
  LoopCloser closer(shared, options);
  ASSERT_TRUE(closer.process(last, report));
  EXPECT_NEAR(report.correction, 0.02, 0.003);
  EXPECT_LT(report.rotation_deg, 0.2);
}

}  // namespace
}  // namespace covis
