// SPDX-License-Identifier: Apache-2.0
// Mapping, loops and the background in turn.
#include "covis/slam/backend.h"

#include <gtest/gtest.h>

#include "covis/map/test_point_scene.h"

namespace covis {
namespace {

class BackendTest : public testing::Test {
 protected:
  static BackendOptions rgbd() {
    SystemOptions options;
    options.sensor = Sensor::rgbd;
    return BackendOptions(options);
  }
  MappingReport process(const KeyFrameRequest& r) {
    const MappingReport report = backend.process(r, nullptr);
    EXPECT_EQ(shared.read()->check(), "");
    return report;
  }
  KeyFrameRequest request(size_t i, KeyFrameId from = {}) {
    return scene_request(scene, shared, Sensor::rgbd, i, from);
  }

  const PointScene scene = PointScene::wall(800, 40);
  SharedMap shared{scene.camera};
  Backend backend{shared, rgbd()};
};

TEST_F(BackendTest, ReadsItsSlicesOfTheSettings) {
  SystemOptions options;
  options.sensor = Sensor::stereo;
  options.seed = 7;
  options.realtime = true;
  options.loop.min_found = 44;
  options.mapper.ba_key_frames = 12;
  options.tracker.key_frame.close_depth_baselines = 33;
  const BackendOptions slices(options);
  EXPECT_EQ(slices.sensor, Sensor::stereo);
  EXPECT_EQ(slices.seed, 7);
  EXPECT_EQ(slices.schedule, Schedule::realtime);
  EXPECT_EQ(slices.loop.min_found, 44);
  EXPECT_EQ(slices.mapper.ba_key_frames, 12);
  EXPECT_EQ(slices.close_depth_baselines, 33);
}

TEST_F(BackendTest, ASubmapThatIsDiscardedIsForgotten) {
  const KeyFrameId first = process(request(0)).key_frame;
  const uint32_t submap = shared.read()->at(first).submap;
  backend.discard(submap);
  EXPECT_EQ(shared.read()->key_frame_count(), 0u);
  EXPECT_EQ(shared.read()->point_count(), 0u);
  EXPECT_FALSE(process(request(4)).key_frame == first);
}

TEST_F(BackendTest, OnlyTheSubmapThatIsDiscardedGoes) {
  const KeyFrameId old = process(request(0)).key_frame;
  const KeyFrameId first = process(request(6)).key_frame;
  const uint32_t submap = shared.read()->at(first).submap;
  backend.discard(submap);
  EXPECT_NE(shared.read()->find(old), nullptr);
  EXPECT_EQ(shared.read()->find(first), nullptr);
  KeyFrameRequest late = request(10, old);
  late.pose.key_frame = first;
  EXPECT_FALSE(process(late).key_frame.valid()) << "asked for beside a key frame that is gone";
}

// The map is asked for its focal length at its twentieth key frame, and answers a fixed number of key frames later.
TEST_F(BackendTest, TheFocalLengthIsAppliedSoManyKeyFramesAfterItWasAskedFor) {
  Pinhole wrong = scene.camera;
  wrong.fx = wrong.fy = 1.02 * scene.camera.fx;
  SharedMap claimed(wrong);
  Backend asked(claimed, rgbd());
  KeyFrameId last = asked.process(scene_request(scene, claimed, Sensor::rgbd, 0), nullptr).key_frame;
  uint64_t moves = claimed.read()->moves();
  std::vector<size_t> changed;
  for (size_t i = 1; i < 30; ++i) {
    last = asked.process(scene_request(scene, claimed, Sensor::rgbd, i, last), nullptr).key_frame;
    ASSERT_TRUE(last.valid());
    if (claimed.read()->moves() != moves) changed.push_back(i);
    moves = claimed.read()->moves();
  }
  asked.finish();
  EXPECT_EQ(claimed.read()->check(), "");
  for (const size_t i : changed) EXPECT_GE(i, 21u);
}

TEST_F(BackendTest, FinishingTwiceIsNoHarm) {
  process(request(0));
  backend.finish();
  backend.finish();
  EXPECT_EQ(shared.read()->check(), "");
}

}  // namespace
}  // namespace covis
