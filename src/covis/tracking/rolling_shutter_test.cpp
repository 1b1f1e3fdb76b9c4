// SPDX-License-Identifier: Apache-2.0
#include "covis/tracking/rolling_shutter.h"

#include <gtest/gtest.h>

#include <cmath>

#include "covis/core/test_allocation_counts.h"
#include "covis/features/test_rolling.h"
#include "covis/tracking/frame_matcher.h"
#include "covis/tracking/test_frame.h"

namespace covis {
namespace {

constexpr int kRows = 480;

// Key frames of a camera at rest, and noisy frames of one that sways.
struct RollingShutterTest : testing::Test {
  RollingShutterTest() {
    world.add_key_frames(4);
    noisy.noise = 0.5;
  }
  // The turn of the rays of frame k, radians a second.
  static Eigen::Vector3d rate(int k) {
    return {0.6 * std::sin(0.3 * k), 1.2 * std::cos(0.21 * k), 0.5 * std::sin(0.11 * k)};
  }
  FeaturesPtr seen(int k, double readout) const {
    const PointScene::View view = noisy.view(scene.T_cw(3), Sensor::monocular, static_cast<uint64_t>(100 + k));
    const auto features = std::make_shared<Features>(*view.features);
    roll(scene.camera, readout / kRows * rate(k), *features);
    return features;
  }
  // Tracks frames from `first` up to `end` by a camera of this readout; returns the one in which it was found, or -1.
  int track(RollingShutter& shutter, double readout, int first, int end, double biased_focal = 1) {
    Pinhole camera = scene.camera;
    camera.fx *= biased_focal;
    for (const KeyFrameId id : world.frames) {
      TrackedFrame frame;
      frame.stamp = world.shared.read()->at(id).stamp;
      shutter.keep(frame, Eigen::Vector3d::Zero());
    }
    int found = -1;
    for (int k = first; k < end; ++k) {
      const PointScene::View view = noisy.view(scene.T_cw(3), Sensor::monocular, static_cast<uint64_t>(100 + k));
      const PointScene::View given{shutter.straighten(seen(k, readout), camera, rate(k)), view.point};
      TrackedFrame frame = frame_of(given, scene.T_cw(3), 100 + k, 100 + k);
      match_points(frame, given, world);
      matcher.fit_pose(frame, camera);
      const auto map = world.shared.read();
      if (shutter.observe(frame, camera, rate(k), *map, world.frames.back()) && found < 0) found = k;
    }
    return found;
  }

  const PointScene scene = PointScene::wall();
  SceneMap world{scene, Sensor::monocular};
  PointScene noisy = scene;
  FrameMatcher matcher;
};

TEST_F(RollingShutterTest, IsFoundWhereTheCameraTurns) {
  RollingShutter shutter(-1, kRows);
  EXPECT_EQ(shutter.readout(), 0);
  const int found = track(shutter, 0.02, 0, 200);
  EXPECT_GT(found, 50);
  EXPECT_NEAR(shutter.readout(), 0.02, 0.001);
}

TEST_F(RollingShutterTest, MayBeginWithTheLastRow) {
  RollingShutter shutter(-1, kRows);
  track(shutter, -0.02, 0, 200);
  EXPECT_NEAR(shutter.readout(), -0.02, 0.001);
}

TEST_F(RollingShutterTest, IsNotFoundWhereAllRowsAreExposedAtOnce) {
  RollingShutter shutter(-1, kRows);
  EXPECT_EQ(track(shutter, 0, 0, 200), -1);
  EXPECT_EQ(track(shutter, 0, 200, 400, 1.02), -1) << "a wrong focal length is none";
  EXPECT_EQ(shutter.readout(), 0);
}

TEST_F(RollingShutterTest, OneThatWasGivenIsTakenOutAtOnce) {
  RollingShutter given(0.02, kRows), none(0, kRows);
  EXPECT_EQ(given.readout(), 0.02);
  const FeaturesPtr rolled = seen(3, 0.02), straight = given.straighten(rolled, scene.camera, rate(3));
  const FeaturesPtr truth = seen(3, 0);
  for (size_t i = 0; i < truth->x.size(); ++i) EXPECT_NEAR(straight->x[i], truth->x[i], 0.02);
  EXPECT_EQ(given.straighten(rolled, scene.camera, std::nullopt), rolled) << "nothing is known of the turn";
  EXPECT_EQ(given.straighten(rolled, scene.camera, Eigen::Vector3d(0, 20, 0)), rolled) << "no camera turns so fast";
  EXPECT_EQ(none.straighten(rolled, scene.camera, rate(3)), rolled);
  EXPECT_EQ(track(given, 0.03, 0, 120), -1);
  EXPECT_EQ(track(none, 0.03, 0, 120), -1);
  EXPECT_EQ(none.readout(), 0);
}

TEST_F(RollingShutterTest, AllocatesNothingInTheSteadyState) {
  RollingShutter shutter(0.02, kRows);
  const FeaturesPtr rolled = seen(3, 0.02);
  for (int k = 0; k < 5; ++k) shutter.straighten(rolled, scene.camera, rate(3));
  const long before = own_allocations;
  shutter.straighten(rolled, scene.camera, rate(3));
  EXPECT_EQ(own_allocations, before);
}

}  // namespace
}  // namespace covis
