// SPDX-License-Identifier: Apache-2.0
// Mapping, loops and the background in turn.
#include "covis/slam/backend.h"

#include <gtest/gtest.h>

#include "covis/map/map_memory.h"
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
  options.tracker.key_frame.close_depth.baselines = 33;
  const BackendOptions slices(options);
  EXPECT_EQ(slices.sensor, Sensor::stereo);
  EXPECT_EQ(slices.seed, 7);
  EXPECT_EQ(slices.schedule, Schedule::realtime);
  EXPECT_EQ(slices.loop.min_found, 44);
  EXPECT_EQ(slices.mapper.ba_key_frames, 12);
  EXPECT_EQ(slices.tracker.key_frame.close_depth.baselines, 33);
}

TEST_F(BackendTest, ASubmapThatIsDiscardedIsForgotten) {
  const KeyFrameId first = process(request(0)).key_frame;
  const uint32_t submap = shared.read()->at(first).submap;
  backend.discard(submap);
  EXPECT_EQ(shared.read()->key_frame_count(), 0u);
  EXPECT_EQ(shared.read()->point_count(), 0u);
  EXPECT_FALSE(process(request(4)).key_frame == first);
}

TEST_F(BackendTest, EarlierFramesAreLocatedWithTheKeyFrameThatBringsThem) {
  const KeyFrameId first = process(request(4)).key_frame;
  KeyFrameRequest r = request(5, first);
  const auto view = [&](size_t i) { return scene.view(scene.T_cw(i), Sensor::rgbd, i).features; };
  r.unlocated = {{3, 3, view(3), first}, {2, 2, view(2), first}};
  const MappingReport report = process(r);
  ASSERT_EQ(report.earlier.located.size(), 2u);
  EXPECT_EQ(report.earlier.located[0].frame, 3);
  const SE3 T_cw = report.earlier.located[1].pose.T_cw(*shared.read());
  EXPECT_LT((T_cw.centre() - scene.T_wc_of(2).t()).norm(), 0.01);
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

TEST_F(BackendTest, AnotherRollingShutterIsAppliedOnceHoweverManyKeyFramesAskedForIt) {
  constexpr double kRowTime = 4e-5;
  KeyFrameId last = process(request(0)).key_frame;
  for (size_t i = 1; i < 8; ++i) {
    KeyFrameRequest r = request(i, last);
    r.shutter = ShutterChange{0, kRowTime * static_cast<double>(i)};
    last = process(r).key_frame;
    const double in_use = shared.read()->camera().row_time;
    EXPECT_EQ(in_use, i < 3 ? 0 : kRowTime) << "key frame " << i;
  }
  KeyFrameRequest doubted = request(8, last);
  doubted.shutter = ShutterChange{kRowTime, 0};
  doubted.doubted_depth = true;
  process(doubted);
  backend.finish();
  EXPECT_EQ(shared.read()->camera().row_time, kRowTime) << "its depth is doubted";
}

// A camera that drives forward and turns, and has another focal length than the map is reported. The map is asked for
// it at its twentieth key frame, and the answer is applied a fixed number of key frames later.
TEST_F(BackendTest, TheFocalLengthIsAppliedSoManyKeyFramesAfterItWasAskedFor) {
  PointScene drive;
  drive.noise = 0.3;
  Random random(3);
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  for (int k = 0; k < 24; ++k) {
    drive.T_wc.emplace_back(so3_exp({0, 0.05 * k, 0}), centre);
    centre += drive.T_wc.back().R() * Eigen::Vector3d(0, 0, 0.4);
  }
  for (size_t p = 0; p < 1600; ++p) {
    const Eigen::Vector3d p_c(random.uniform(-4, 4), random.uniform(-3, 3), random.uniform(4, 12));
    drive.add_point(drive.T_wc_of(p) * p_c, 16, random);
  }
  Pinhole wrong = drive.camera;
  wrong.fx = wrong.fy = 1.02 * drive.camera.fx;
  SharedMap claimed(wrong);
  BackendOptions options = rgbd();
  options.mapper.cull_redundancy = 1;  // no key frame goes
  Backend asked(claimed, options);
  KeyFrameId last;
  size_t changed = 0;
  for (size_t i = 0; i < drive.T_wc.size(); ++i) {
    KeyFrameRequest r = scene_request(drive, claimed, Sensor::rgbd, i, last);
    const auto matched = r.points;
    for (uint32_t f = 0; f < matched.size(); ++f) {
      if (!matched[f].valid() && i > 0) r.new_points.push_back(f);
    }
    last = asked.process(r, nullptr).key_frame;
    ASSERT_TRUE(last.valid());
    if (changed == 0 && claimed.read()->camera().fx != wrong.fx) changed = i;
  }
  // Asked for when twenty key frames are made, applied two later.
  EXPECT_EQ(changed, 19u + 2u);
}

TEST_F(BackendTest, DepthIsNotComparedWhileAnotherKeyFrameWaits) {
  Pinhole camera = scene.camera;
  camera.depth_noise = DepthNoise::kinect();
  for (const bool waits : {false, true}) {
    SharedMap map(camera);
    Backend asked(map, rgbd());
    const std::atomic<bool> interrupt = waits;
    const KeyFrameId first = asked.process(scene_request(scene, map, Sensor::rgbd, 0), &interrupt).key_frame;
    const MappingReport report = asked.process(scene_request(scene, map, Sensor::rgbd, 3, first), &interrupt);
    ASSERT_TRUE(report.key_frame.valid());
    EXPECT_EQ(report.depth_checks.empty(), waits);
  }
}

TEST_F(BackendTest, AMapOnNewGroundStaysWithinItsBoundLong) {
  constexpr size_t kViews = 100;
  const PointScene way = PointScene::wall(2500, 5 * kViews);
  SharedMap map(way.camera);
  BackendOptions options = rgbd();
  options.mapper.max_map_mb = 1;
  Backend bounded(map, options);
  int made = 0, thinned = 0, culled = 0;
  KeyFrameId last;
  for (size_t k = 0; k < kViews; ++k) {
    const MappingReport report = bounded.process(scene_request(way, map, Sensor::rgbd, 5 * k, last), nullptr);
    last = report.key_frame;
    made += last.valid();
    culled += report.counts.key_frames_culled;
    thinned += report.counts.key_frames_thinned;
  }
  EXPECT_GT(thinned, 10);
  EXPECT_EQ(map.read()->check(), "");
  EXPECT_EQ(map.read()->key_frame_count(), static_cast<size_t>(made - culled - thinned));
  EXPECT_LT(memory_of(*map.read()), 1'150'000u) << "some key frames more until it is looked at again";
}

TEST_F(BackendTest, FinishingTwiceIsNoHarm) {
  process(request(0));
  backend.finish();
  backend.finish();
  EXPECT_EQ(shared.read()->check(), "");
}

}  // namespace
}  // namespace covis
