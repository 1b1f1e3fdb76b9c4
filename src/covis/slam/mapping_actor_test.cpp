// SPDX-License-Identifier: Apache-2.0
#include "covis/slam/mapping_actor.h"

#include <gmock/gmock.h>

#include <memory>

#include "covis/slam/test_frames.h"

namespace covis {
namespace {

class MappingActorTest : public testing::Test {
 protected:
  MappingActorTest() {
    options.sensor = Sensor::rgbd;
    actor = std::make_unique<MappingActor>(shared, options);
  }

  KeyFrameRequest first() {
    KeyFrameRequest r;
    r.features = frames.features(0);
    r.points.resize(static_cast<size_t>(r.features->size()));
    r.new_points = features_with_depth(*r.features);
    return r;
  }
  KeyFrameRequest next(int i, KeyFrameId from) {
    KeyFrameRequest r;
    r.frame = i;
    r.stamp = frames.stamp(i);
    r.features = frames.features(i);
    const auto map = shared.read();
    r.points = points_seen(*map, from, *r.features, frames.T_cw(i));
    r.pose.key_frame = from;
    r.pose.T_cr = frames.T_cw(i) * map->at(from).T_cw.inverse();
    return r;
  }

  TestFrames& frames = TestFrames::of(Sensor::rgbd);
  SystemOptions options;
  SharedMap shared{frames.camera()};
  std::unique_ptr<MappingActor> actor;
};

TEST_F(MappingActorTest, WaitingUntilItIsIdleTakesNoReport) {
  actor->wait_idle();
  actor->submit(first());
  actor->wait_idle();
  EXPECT_TRUE(actor->idle());
  EXPECT_EQ(shared.read()->key_frame_count(), 1u);
  EXPECT_EQ(actor->pending(), 1);
  EXPECT_TRUE(actor->wait().key_frame.valid());
}

TEST_F(MappingActorTest, ReportsComeInTheOrderOfTheirRequests) {
  EXPECT_EQ(actor->pending(), 0);
  EXPECT_TRUE(actor->idle());
  EXPECT_FALSE(actor->poll());
  actor->submit(first());
  EXPECT_EQ(actor->pending(), 1);
  const KeyFrameId root = actor->wait().key_frame;
  ASSERT_TRUE(root.valid());
  EXPECT_EQ(actor->pending(), 0);
  for (const int i : {3, 6, 9}) actor->submit(next(i, root));
  EXPECT_EQ(actor->pending(), 3);
  for (const int i : {3, 6, 9}) EXPECT_EQ(actor->wait().frame, i);
  EXPECT_EQ(actor->pending(), 0);
  EXPECT_TRUE(actor->idle());
  EXPECT_EQ(shared.read()->check(), "");
}

TEST_F(MappingActorTest, PollTakesAReportOnceItIsThere) {
  actor->submit(first());
  std::optional<MappingReport> report;
  while (!report) report = actor->poll();
  EXPECT_TRUE(report->key_frame.valid());
  EXPECT_EQ(actor->pending(), 0);
  EXPECT_FALSE(actor->poll());
}

TEST_F(MappingActorTest, EndsWithWorkInItsInbox) {
  actor->submit(first());
  const KeyFrameId root = actor->wait().key_frame;
  for (const int i : {3, 6, 9}) actor->submit(next(i, root));
  actor.reset();
  EXPECT_EQ(shared.read()->key_frame_count(), 4u) << "what was submitted is worked off";
  EXPECT_EQ(shared.read()->check(), "");
}

TEST_F(MappingActorTest, AReaderBesideItSeesWholeMaps) {
  actor->submit(first());
  const KeyFrameId root = actor->wait().key_frame;
  for (const int i : {3, 6, 9}) actor->submit(next(i, root));
  while (actor->pending() > 0) {
    EXPECT_EQ(shared.read()->check(), "");
    actor->poll();
  }
  EXPECT_EQ(shared.read()->key_frame_count(), 4u);
}

}  // namespace
}  // namespace covis
