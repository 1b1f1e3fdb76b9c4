// SPDX-License-Identifier: Apache-2.0
#include "covis/slam/trajectory_log.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <thread>

#include "covis/map/test_map.h"

namespace covis {
namespace {

// Two key frames a metre apart in one submap, a third in a submap of its own.
class TrajectoryLogTest : public testing::Test, protected MapFixture {
 protected:
  const KeyFrameId a = frame(0), b = frame(1), alone = map.begin_submap(40, 0, pose_at(0), features(400, false));

  void append(int64_t frame) { log.append({.frame = frame, .stamp = 10 * frame, .pose = {}, .online = {}}); }
  // A frame that was tracked half a metre to the right of the key frame.
  void append_tracked(int64_t frame, KeyFrameId reference) {
    log.append({.frame = frame,
                .stamp = 10 * frame,
                .pose = RelativePose{reference, 1, pose_at(0.5)},
                .online = SubmapPose{pose_at(7).inverse(), map.at(reference).submap}});
  }
  FrameRecord record(size_t index) const { return log.records().at(index); }
  // The frame's place along x, as the map has it now.
  double x_of(const FrameRecord& record) const {
    return record.pose.value().resolved(map).value().T_cw(map).centre().x();
  }

  TrajectoryLog log;
};

TEST_F(TrajectoryLogTest, KeepsFramesInTheirOrderWithAndWithoutAPose) {
  EXPECT_FALSE(log.last());
  append(1);
  append_tracked(3, b);
  ASSERT_EQ(log.records().size(), 2u);
  EXPECT_EQ(record(0).frame, 1);
  EXPECT_FALSE(record(0).pose || record(0).online);
  EXPECT_EQ(record(1).stamp, 30);
  EXPECT_NEAR(x_of(record(1)), 1.5, 1e-12);
  EXPECT_EQ(log.last()->frame, 3);
}

// The second key frame was a metre away, and is two with another camera.
TEST_F(TrajectoryLogTest, FramesFollowKeyFramesThatMovedWithAnotherCamera) {
  const auto follow = [&] {
    KeyFrameMoves moves{.of = {{a, 0, 1, pose_at(0), pose_at(0)}, {b, 10, 1, pose_at(1), pose_at(2)}}, .moves = 7};
    map.set_pose(b, pose_at(2));
    log.follow(map, moves);
  };
  append(0);
  append_tracked(5, a);
  append(10);
  append_tracked(20, b);
  log.append({.frame = 30, .stamp = 300, .pose = RelativePose{b, 1, pose_at(0.5)}, .moves = 7, .online = {}});
  append_tracked(31, alone);
  log.anchor(0, RelativePose::at(map, a));
  log.anchor(10, RelativePose::at(map, b));
  const uint64_t revision = log.revision();
  follow();
  EXPECT_GT(log.revision(), revision);
  EXPECT_NEAR(x_of(record(0)), 0, 1e-12);
  EXPECT_NEAR(x_of(record(1)), 1, 1e-9) << "half way";
  EXPECT_NEAR(x_of(record(2)), 2, 1e-12);
  EXPECT_NEAR(x_of(record(3)), 2.5, 1e-9) << "beside its reference";
  EXPECT_NEAR(x_of(record(4)), 2.5, 1e-9) << "tracked with that camera";
  EXPECT_NEAR(x_of(record(5)), 0.5, 1e-9) << "in another submap";
  EXPECT_NEAR(record(1).online->T_wc.t().x(), 7, 1e-12);
}

TEST_F(TrajectoryLogTest, KeepsAsManyOfTheNewestFramesAsItIsAskedTo) {
  TrajectoryLog bounded(3);
  for (int i = 0; i < 20; ++i) {
    bounded.append({.frame = i, .stamp = 10 * i, .pose = {}, .online = {}});
    bounded.make_room();
    const std::vector<FrameRecord> kept = bounded.records();
    EXPECT_GE(kept.size(), static_cast<size_t>(std::min(i + 1, 3)));
    EXPECT_LE(kept.size(), 6u);
    EXPECT_EQ(kept.back().frame, i);
    EXPECT_EQ(kept.front().frame, i + 1 - static_cast<int>(kept.size())) << "none is missing between";
  }
}

TEST_F(TrajectoryLogTest, AGreatBoundAsksForNoMemoryBeforeItIsUsed) {
  TrajectoryLog bounded(size_t{1} << 50);
  for (int i = 0; i < 20'000; ++i) {
    bounded.make_room();
    bounded.append({.frame = i, .stamp = 10 * i, .pose = {}, .online = {}});
  }
  EXPECT_EQ(bounded.records().size(), 20'000u);
}

TEST_F(TrajectoryLogTest, ACorrectionMovesThePoseNotTheOneItWasTrackedWith) {
  append_tracked(1, b);
  map.set_pose(b, pose_at(2));
  EXPECT_NEAR(x_of(record(0)), 2.5, 1e-12);
  EXPECT_NEAR(record(0).online->T_wc.t().x(), 7, 1e-12);
}

TEST_F(TrajectoryLogTest, AFrameThatBecameAKeyFrameIsItsOwnReference) {
  append_tracked(1, b);
  append_tracked(2, b);
  log.anchor(1, RelativePose::at(map, a), SubmapPose{pose_at(3).inverse(), 0});
  EXPECT_EQ(record(0).pose->key_frame, a);
  EXPECT_NEAR(x_of(record(0)), 0, 1e-12);
  EXPECT_NEAR(record(0).online->T_wc.t().x(), 7, 1e-12) << "the pose it was tracked with stays";
  EXPECT_EQ(record(1).pose->key_frame, b) << "other frames stay as they are";
}

TEST_F(TrajectoryLogTest, AFrameWithoutAPoseGetsOneWhenItBecomesAKeyFrame) {
  append(1);
  append(2);
  log.anchor(1, RelativePose::at(map, a));
  log.anchor(2, RelativePose::at(map, b), SubmapPose{pose_at(3).inverse(), 0});
  EXPECT_TRUE(record(0).pose);
  EXPECT_FALSE(record(0).online) << "the first view of a monocular submap had no pose when it was tracked";
  EXPECT_NEAR(record(1).online->T_wc.t().x(), 3, 1e-12);
}

TEST_F(TrajectoryLogTest, AFrameLocatedAfterwardsHasNoPoseOfWhenItWasTracked) {
  append(1);
  append_tracked(2, b);
  for (const int64_t frame : {1, 2, 3}) log.locate({frame, {a, 1, pose_at(0.25)}});
  EXPECT_NEAR(x_of(record(0)), 0.25, 1e-12);
  EXPECT_FALSE(record(0).online);
  EXPECT_NEAR(x_of(record(1)), 1.5, 1e-12) << "one that has a pose keeps it";
  EXPECT_EQ(log.records().size(), 2u) << "a frame that is not known stays so";
}

TEST_F(TrajectoryLogTest, AFrameLocatedAfterwardsKeepsNothingOfAPoseThatWasTakenBack) {
  ShutterResponse shutter;
  shutter.move[3] = 1;
  log.append({.frame = 1, .stamp = 10, .pose = RelativePose{b, 1, pose_at(0.5)}, .shutter = shutter, .online = {}});
  log.retract(1);
  log.locate({1, {a, 1, pose_at(0.25)}});
  ASSERT_TRUE(record(0).pose);
  EXPECT_TRUE(record(0).shutter.move.isZero(0));
}

TEST_F(TrajectoryLogTest, AKeyFrameOfAnEarlierRecordingIsNoFrameOfThisOne) {
  append(2);
  append(4);
  const uint64_t before = log.revision();
  for (const int64_t frame : {1, 3, 5}) log.anchor(frame, RelativePose::at(map, a));
  EXPECT_FALSE(record(0).pose || record(1).pose);
  EXPECT_EQ(log.revision(), before);
}

TEST_F(TrajectoryLogTest, RetractsFromAFrameOn) {
  for (int64_t frame = 0; frame < 4; ++frame) append_tracked(2 * frame, a);
  log.retract(3);
  EXPECT_TRUE(record(1).pose && record(1).online);
  for (const size_t later : {2, 3}) EXPECT_FALSE(record(later).pose || record(later).online) << later;
  EXPECT_EQ(log.records().size(), 4u) << "the frames themselves stay";
}

TEST_F(TrajectoryLogTest, ForgetsTheFramesOfASubmap) {
  append_tracked(0, a);
  append_tracked(1, alone);
  append(2);
  append_tracked(3, b);
  log.forget(map, map.at(alone).submap);
  EXPECT_TRUE(record(0).pose);
  EXPECT_FALSE(record(1).pose || record(1).online);
  EXPECT_TRUE(record(3).pose);
}

// A camera that goes to and fro for hours: key frames are made and erased all the time.
TEST_F(TrajectoryLogTest, ErasedKeyFramesAreForgottenWhenNoFrameRefersToThem) {
  uint64_t forgotten = 0;
  size_t most = 0;
  for (int i = 0; i < 5000; ++i) {
    const KeyFrameId passing = frame(2);
    map.attach_to_tree(passing);
    append_tracked(i, passing);
    ASSERT_TRUE(map.erase_key_frame(passing));
    if (const auto forgettable = log.reanchor(map)) {
      forgotten = *forgettable;
      map.forget_erased(forgotten);
    }
    most = std::max(most, map.erased_count());
  }
  EXPECT_GT(forgotten, 2000u);
  EXPECT_LT(most, 2100u) << "two rounds of them are kept";
  for (const size_t k : {size_t{0}, size_t{2500}, size_t{4999}}) EXPECT_NEAR(x_of(record(k)), 2.5, 1e-9) << k;
  map.set_pose(b, pose_at(4));
  map.set_pose(a, pose_at(3));
  EXPECT_GT(std::abs(x_of(record(0)) - 2.5), 1) << "they go on to follow what they are relative to";
}

TEST_F(TrajectoryLogTest, TheRevisionRisesWithEveryChange) {
  uint64_t last = log.revision();
  const auto expect_risen = [&] {
    EXPECT_GT(log.revision(), last);
    last = log.revision();
  };
  append_tracked(1, a);
  expect_risen();
  log.anchor(1, RelativePose::at(map, a));
  expect_risen();
  log.retract(1);
  expect_risen();
  log.forget(map, 0);
  expect_risen();
  (void)log.records();
  (void)log.last();
  log.make_room();
  EXPECT_EQ(log.revision(), last);
}

TEST_F(TrajectoryLogTest, IsReadByAnyThreadWhileAnotherWrites) {
  std::atomic<bool> seen{false};
  std::jthread reader([&](const std::stop_token& stop) {
    size_t most = 0;
    while (!stop.stop_requested()) {
      const std::vector<FrameRecord> records = log.records();
      EXPECT_GE(records.size(), most) << "frames are never dropped";
      most = records.size();
      for (size_t i = 0; i < records.size(); ++i) EXPECT_EQ(records[i].frame, static_cast<int64_t>(i));
      seen = most > 0;
    }
  });
  for (int64_t frame = 0; frame < 500 || !seen; ++frame) {
    append_tracked(frame, a);
    if (frame % 10 == 0) log.make_room();
    if (frame % 50 == 0) log.retract(frame - 3);
  }
}

}  // namespace
}  // namespace covis
