// SPDX-License-Identifier: Apache-2.0
#include "covis/loops/shutter_adjustment.h"

#include <gtest/gtest.h>

#include <cmath>

#include "covis/features/straightening.h"
#include "covis/features/test_rolling.h"
#include "covis/map/test_point_scene.h"

namespace covis {
namespace {

constexpr double kRowTime = 0.02 / 480;

// A map whose key frames were made while the camera swayed. The first does not know how.
struct SwayedMap {
  SwayedMap() {
    world.add_key_frames(8);
    const auto map = world.shared.write();
    for (size_t i = 1; i < world.frames.size(); ++i) {
      auto features = std::make_shared<Features>(*world.views[i].features);
      const Eigen::Vector3d rate(0.5 * std::sin(2.0 * static_cast<double>(i)), i % 2 ? 1 : -1, 0.3);
      roll(scene.camera, kRowTime * rate, *features);
      features->exposure.rate = rate;
      map->set_features(world.frames[i], features);
    }
  }
  // The greatest distance of a keypoint from where its point is seen in truth, pixels.
  double worst() const {
    const auto map = world.shared.read();
    double most = 0;
    for (size_t i = 0; i < world.frames.size(); ++i) {
      const Features& f = *map->at(world.frames[i]).features;
      const Features& truth = *world.views[i].features;
      for (size_t k = 0; k < f.x.size(); ++k)
        most = std::max<double>(most, std::hypot(f.x[k] - truth.x[k], f.y[k] - truth.y[k]));
    }
    return most;
  }
  void adjust(double row_time) {
    auto job = ShutterAdjustment::of(*world.shared.read(), row_time);
    ASSERT_TRUE(job);
    const std::atomic<bool> interrupt{false};
    ASSERT_TRUE(job->run(interrupt));
    ASSERT_TRUE(job->apply(world.shared));
  }

  const PointScene scene = PointScene::wall();
  SceneMap world{scene, Sensor::monocular};
};

TEST(ShutterAdjustment, TakesTheTurnOutOfTheKeyFramesOfAMap) {
  SwayedMap swayed;
  EXPECT_GT(swayed.worst(), 2) << "pixels";
  const uint64_t moves = swayed.world.shared.read()->moves();
  swayed.adjust(kRowTime);
  EXPECT_LT(swayed.worst(), 0.05);
  const auto map = swayed.world.shared.read();
  EXPECT_EQ(map->camera().row_time, kRowTime);
  EXPECT_GT(map->moves(), moves);
  EXPECT_EQ(map->check(), "");
  for (size_t i = 0; i < swayed.world.frames.size(); ++i) {
    const SE3 off = map->at(swayed.world.frames[i]).T_cw * swayed.scene.T_cw(i).inverse();
    EXPECT_LT(off.log().tail<3>().norm(), 1e-3) << "key frame " << i;
  }
}

TEST(ShutterAdjustment, EverySubmapIsAdjusted) {
  SwayedMap swayed;
  SceneMap& world = swayed.world;
  world.begin_submap();
  world.add_key_frames(8);
  const SE3 moved = SE3::exp((Vector6d() << 0.02, -0.01, 0, 0.002, 0.004, 0).finished());
  for (size_t i = 10; i < 16; ++i) {
    const SE3 T_cw = moved * swayed.scene.T_cw(i - 8);
    world.shared.write()->set_pose(world.frames[i], T_cw);
  }
  swayed.adjust(kRowTime);
  const auto map = world.shared.read();
  EXPECT_EQ(map->check(), "");
  for (size_t i = 8; i < 16; ++i) {
    const SE3 off = map->at(world.frames[i]).T_cw * swayed.scene.T_cw(i - 8).inverse();
    EXPECT_LT(off.log().tail<3>().norm(), 1e-3) << "key frame " << i - 8 << " of the other submap";
  }
}

TEST(ShutterAdjustment, CanBeTakenBack) {
  SwayedMap swayed;
  const double before = swayed.worst();
  swayed.adjust(kRowTime);
  swayed.adjust(0);
  EXPECT_NEAR(swayed.worst(), before, 0.05);
  EXPECT_EQ(swayed.world.shared.read()->camera().row_time, 0);
}

TEST(ShutterAdjustment, OneThatIsInterruptedHasNoResult) {
  SwayedMap swayed;
  auto job = ShutterAdjustment::of(*swayed.world.shared.read(), kRowTime);
  EXPECT_FALSE(job->run(std::atomic<bool>{true}));
}

}  // namespace
}  // namespace covis
