// SPDX-License-Identifier: Apache-2.0
#include "covis/slam/mapping_actor.h"

#include <gmock/gmock.h>

#include <memory>

#include "covis/core/test_allocations.h"
#include "covis/map/test_point_scene.h"

namespace covis {
namespace {

class MappingActorTest : public testing::Test {
 protected:
  MappingActorTest() {
    SystemOptions options;
    options.sensor = Sensor::rgbd;
    actor = std::make_unique<MappingActor>(shared, BackendOptions(options));
  }

  KeyFrameRequest first() { return scene_request(scene, shared, Sensor::rgbd, 0); }
  KeyFrameRequest next(size_t i, KeyFrameId from) { return scene_request(scene, shared, Sensor::rgbd, i, from); }

  const PointScene scene = PointScene::wall(1200);
  SharedMap shared{scene.camera};
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

TEST_F(MappingActorTest, ARequestThatMemoryDoesNotSufficeForIsNotWaitedFor) {
  KeyFrameRequest request = first();
  own_failure_in = 1;
  EXPECT_THROW(actor->submit(std::move(request)), std::bad_alloc);
  own_failure_in = 0;
  EXPECT_EQ(actor->pending(), 0);
  EXPECT_TRUE(actor->idle());
  actor->wait_idle();
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
  for (const size_t i : {3u, 6u, 9u}) actor->submit(next(i, root));
  EXPECT_EQ(actor->pending(), 3);
  for (const int64_t i : {3, 6, 9}) EXPECT_EQ(actor->wait().frame, i);
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
  for (const size_t i : {3u, 6u, 9u}) actor->submit(next(i, root));
  actor.reset();
  EXPECT_EQ(shared.read()->key_frame_count(), 4u) << "what was submitted is worked off";
  EXPECT_EQ(shared.read()->check(), "");
}

TEST_F(MappingActorTest, AReaderBesideItSeesWholeMaps) {
  actor->submit(first());
  const KeyFrameId root = actor->wait().key_frame;
  for (const size_t i : {3u, 6u, 9u}) actor->submit(next(i, root));
  while (actor->pending() > 0) {
    EXPECT_EQ(shared.read()->check(), "");
    actor->poll();
  }
  EXPECT_EQ(shared.read()->key_frame_count(), 4u);
}

TEST_F(MappingActorTest, ASubmapIsDiscardedAfterTheRequestsBeforeIt) {
  actor->submit(first());
  actor->discard(0);
  EXPECT_TRUE(actor->idle());
  EXPECT_EQ(shared.read()->key_frame_count(), 0u) << "the key frame was made, and then erased with its submap";
  EXPECT_EQ(actor->pending(), 1) << "the message itself is not answered";
  EXPECT_TRUE(actor->wait().key_frame.valid());
}

TEST_F(MappingActorTest, ErasedKeyFramesAreForgottenOnItsThread) {
  actor->submit(first());
  const KeyFrameId root = actor->wait().key_frame;
  actor->submit(next(3, root));
  const KeyFrameId erased = actor->wait().key_frame;
  shared.write()->erase_key_frame(erased);
  ASSERT_EQ(shared.read()->erased_count(), 1u);
  actor->forget_erased(1);
  actor->wait_idle();
  EXPECT_EQ(actor->pending(), 0) << "the message is not answered";
  EXPECT_EQ(shared.read()->erased_count(), 0u);
}

TEST_F(MappingActorTest, FinishingWaitsForTheRequestsBeforeIt) {
  actor->submit(first());
  const KeyFrameId root = actor->wait().key_frame;
  for (const size_t i : {3u, 6u, 9u}) actor->submit(next(i, root));
  actor->finish();
  EXPECT_TRUE(actor->idle());
  EXPECT_EQ(shared.read()->key_frame_count(), 4u);
  EXPECT_EQ(actor->pending(), 3);
}

}  // namespace
}  // namespace covis
