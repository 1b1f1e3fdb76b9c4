// SPDX-License-Identifier: Apache-2.0
// A single camera whose lens has distortion, given without: the distortion is found as the map grows, taken out of all
// keypoints, saved with the map, and known where the map is used again.
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>

#include "covis/features/straightening.h"
#include "covis/storage/map_file.h"
#include "rendered.h"

namespace covis {
namespace {

constexpr int kFrames = 320;
constexpr double kStrength = 0.3;  // strength of the lens, as covis synth counts it
constexpr double kLeft = 0.5;      // pixels: greatest error of a keypoint's place at the end; at first it is 3

class LeftDistortion : public testing::Test {
 protected:
  static Recording& recording() {
    static Recording made(Sensor::monocular, kFrames, 10, "posters", {}, kStrength);
    return made;
  }
  static Camera claimed() {
    Camera camera = recording().synth.camera();
    camera.distortion = Distortion::none;
    camera.coefficients = {};
    return camera;
  }
  static SystemOptions options() { return options_for(Sensor::monocular); }
  static int track(System& system, int from, int to) {
    int tracked = 0;
    for (int i = from; i < to; ++i)
      tracked += system.process(recording().frame(i)).track.state == TrackingState::tracking;
    return tracked;
  }
  static void expect_found(const System& system) {
    const Pinhole camera = system.camera();
    const Camera truth = recording().synth.camera();
    for (int u = 40; u <= truth.width - 40; u += 40) {
      for (int v = 40; v <= truth.height - 40; v += 40) {
        const Eigen::Vector2d straight = truth.undistort({u, v}).value();
        EXPECT_LT((camera.straightened({u, v}).value() - straight).norm(), kLeft) << u << ", " << v;
      }
    }
    EXPECT_EQ(camera.fx, truth.pinhole.fx) << "the focal length that was given was right";
    expect_straight(system);
  }
  static void expect_straight(const System& system) {
    const auto map = system.map().read();
    EXPECT_EQ(map->check(), "");
    for (const KeyFrameId& id : map->key_frames()) EXPECT_TRUE(straight_for(*map->at(id).features, map->camera()));
  }
  // A run of all frames, made once for all cases.
  static const System& run() {
    static System system(claimed(), options(), vocabulary());
    static const int tracked = [] {
      const int frames = track(system, 0, kFrames);
      system.finish();
      return frames;
    }();
    EXPECT_GT(tracked, kFrames * 7 / 10);
    return system;
  }
};

TEST_F(LeftDistortion, IsFoundLong) { expect_found(run()); }

TEST_F(LeftDistortion, IsLeftWhenToldToLong) {
  SystemOptions fixed = options();
  fixed.mapper.refine_distortion = fixed.mapper.refine_focal = false;
  System system(claimed(), fixed, vocabulary());
  track(system, 0, kFrames);
  system.finish();
  EXPECT_EQ(system.camera(), claimed().pinhole);
}

TEST_F(LeftDistortion, IsFoundInRealTime) {
  SystemOptions realtime = options();
  realtime.realtime = true;
  System system(claimed(), realtime, vocabulary());
  for (int i = 0; i < kFrames; ++i) {
    // Locating waits for mapping of the key frame, without which a slow machine would have a poor map.
    if (system.process(recording().frame(i)).track.key_frame) system.locate(recording().frame(i));
  }
  system.finish();
  expect_found(system);
}

// A single image is located with the lens as the map has it, whatever tracking knew last.
TEST_F(LeftDistortion, LocatesWithTheLensThatWasJustFoundLong) {
  System system(claimed(), options(), vocabulary());
  int i = 0;
  for (; i < kFrames && !system.camera().residual.any(); ++i) {
    track(system, i, i + 1);
    system.finish();
  }
  ASSERT_LT(i, kFrames);
  const auto at_once = system.locate(recording().frame(i - 1));
  track(system, i, i + 1);
  system.finish();
  const auto later = system.locate(recording().frame(i - 1));
  ASSERT_TRUE(at_once && later);
  EXPECT_GE(at_once->inliers, later->inliers * 9 / 10);
}

TEST_F(LeftDistortion, IsKeptWithASavedMapLong) {
  const auto file = std::filesystem::path(testing::TempDir()) / ("covis_distortion_" + std::to_string(getpid()));
  storage::MapHeader header;
  header.camera = claimed();
  header.levels = kFewestLevels;
  header.factor = static_cast<float>(options().orb.scale_factor);
  ASSERT_TRUE(storage::save_map(file, run().map_state(), header));
  Camera longer = claimed();
  longer.pinhole.fx *= 1.001;
  longer.pinhole.fy *= 1.001;
  const Camera lens = recording().synth.camera();
  for (const Camera& camera : {claimed(), longer, lens}) {
    for (const bool localize : {false, true}) {
      auto saved = storage::load_map(file);
      ASSERT_TRUE(saved) << saved.error().message;
      SystemOptions on = options();
      on.localize = localize;
      System system(camera, on, vocabulary());
      ASSERT_TRUE(system.set_map(std::move(saved->map), saved->header.camera));
      EXPECT_EQ(system.camera().residual.any(), camera == claimed()) << "another camera has its own";
      expect_straight(system);
      EXPECT_TRUE(system.locate(recording().frame(kFrames - 10)));
      EXPECT_GT(track(system, kFrames - 40, kFrames), camera == longer ? 20 : 30);
      system.finish();
      expect_straight(system);
    }
  }
  std::filesystem::remove(file);
}

}  // namespace
}  // namespace covis
