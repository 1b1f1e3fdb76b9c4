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
  // A step to this frame, in which the camera turned so fast.
  static RollingShutter::Step step(const TrackedFrame& frame, const Eigen::Vector3d& turn_rate) {
    constexpr double kElapsed = 0.03;  // seconds
    Vector6d turn = Vector6d::Zero();
    turn.tail<3>() = kElapsed * turn_rate;
    return {frame, SE3::exp(turn).inverse() * frame.T_cw, frame.stamp - from_seconds(kElapsed), {}};
  }
  // Tracks so many frames by a camera of this readout; returns the first after which it is known, or -1.
  int track(RollingShutter& shutter, double readout, int frames, double biased_focal = 1,
            std::optional<uint64_t> moves = {}) {
    Pinhole camera = scene.camera;
    camera.fx *= biased_focal;
    for (const KeyFrameId id : world.frames) {
      TrackedFrame frame;
      frame.stamp = world.shared.read()->at(id).stamp;
      RollingShutter::Step at_rest = step(frame, Eigen::Vector3d::Zero());
      at_rest.becomes_key_frame = true;
      shutter.follow(at_rest, camera, nullptr, {});
    }
    int found = -1;
    for (int k = 0; k < frames; ++k) {
      const PointScene::View view = noisy.view(scene.T_cw(3), Sensor::monocular, static_cast<uint64_t>(100 + k));
      const PointScene::View given{shutter.straighten(seen(k, readout), camera, rate(k)), view.point};
      TrackedFrame frame = frame_of(given, scene.T_cw(3), 100 + k, from_seconds(1 + 0.03 * k));
      match_points(frame, given, world);
      matcher.fit_pose(frame, camera);
      RollingShutter::Step swaying = step(frame, rate(k));
      swaying.reference = world.frames.back();
      shutter.follow(swaying, camera, &world.shared, moves);
      if (shutter.readout() != 0 && found < 0) found = k;
    }
    return found;
  }

  const PointScene scene = PointScene::wall();
  SceneMap world{scene, Sensor::monocular};
  PointScene noisy = scene;
  FrameMatcher matcher;
};

TEST_F(RollingShutterTest, IsFoundWhereTheCameraTurns) {
  RollingShutter shutter(kFindReadout, kRows);
  EXPECT_EQ(shutter.readout(), 0);
  EXPECT_GT(track(shutter, 0.02, 200), 50);
  EXPECT_NEAR(shutter.readout(), 0.02, 0.001);
}

TEST_F(RollingShutterTest, MayBeginWithTheLastRow) {
  RollingShutter shutter(kFindReadout, kRows);
  track(shutter, -0.02, 200);
  EXPECT_NEAR(shutter.readout(), -0.02, 0.001);
}

TEST_F(RollingShutterTest, IsNotFoundWhereAllRowsAreExposedAtOnce) {
  RollingShutter exact(kFindReadout, kRows), biased(kFindReadout, kRows);
  EXPECT_EQ(track(exact, 0, 200), -1);
  EXPECT_EQ(track(biased, 0, 200, 1.02), -1) << "a wrong focal length is none";
}

TEST_F(RollingShutterTest, AMapThatHasMovedTellsNothing) {
  RollingShutter shutter(kFindReadout, kRows);
  const uint64_t moves = world.shared.read()->moves();
  EXPECT_EQ(track(shutter, 0.02, 120, 1, moves + 1), -1);
  EXPECT_GT(track(shutter, 0.02, 120, 1, moves), 0);
}

TEST_F(RollingShutterTest, OneThatWasGivenIsTakenOutAtOnceAndStays) {
  for (const double readout : {0.02, -0.02}) {
    RollingShutter given(readout, kRows);
    const FeaturesPtr rolled = seen(3, readout), straight = given.straighten(rolled, scene.camera, rate(3));
    const FeaturesPtr truth = seen(3, 0);
    for (size_t i = 0; i < truth->x.size(); ++i) EXPECT_NEAR(straight->x[i], truth->x[i], 0.02);
    EXPECT_EQ(given.straighten(rolled, scene.camera, std::nullopt), rolled) << "nothing is known of the turn";
    EXPECT_EQ(given.straighten(rolled, scene.camera, Eigen::Vector3d(0, 20, 0)), rolled) << "no camera turns so fast";
    track(given, 0.03, 120);
    EXPECT_EQ(given.readout(), readout);
  }
  RollingShutter none(0, kRows);
  const FeaturesPtr rolled = seen(3, 0.02);
  EXPECT_EQ(none.straighten(rolled, scene.camera, rate(3)), rolled);
  EXPECT_EQ(track(none, 0.03, 120), -1);
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
