// SPDX-License-Identifier: Apache-2.0
// A single camera with a wrong initial focal length: it is refined as the map grows, saved with the map, and the same
// for all key frames.
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>

#include "covis/core/log.h"
#include "covis/storage/map_file.h"
#include "rendered.h"

namespace covis {
namespace {

constexpr double kClaimed = 1.02;  // relative to the true focal length
constexpr double kLeft = 0.008;    // greatest relative error allowed at the end; half of the initial one would be 0.01
constexpr int kFrames = 320;

// Returns the recording's camera with its focal length multiplied by `factor`.
Camera camera_of(const Recording& recording, double factor) {
  Camera made = recording.synth.camera();
  made.pinhole.fx *= factor;
  made.pinhole.fy *= factor;
  return made;
}

class FocalLength : public testing::Test {
 protected:
  static Recording& recording() {
    static Recording made(Sensor::monocular, kFrames, 10, "posters");
    return made;
  }
  static Camera camera(double factor) { return camera_of(recording(), factor); }
  static Camera claimed() { return camera(kClaimed); }
  static SystemOptions options() { return options_for(Sensor::monocular); }
  // The error of the present focal length, relative to the truth.
  static double off(const System& system) { return std::abs(system.camera().fx / camera(1).pinhole.fx - 1); }
  static int track(System& system, int from, int to) {
    int tracked = 0;
    for (int i = from; i < to; ++i)
      tracked += system.process(recording().frame(i)).track.state == TrackingState::tracking;
    return tracked;
  }
  // A run of all frames by the default options, made once for all cases. Its map is kept in `file()`.
  struct Run {
    int tracked;
    double off;
    std::string result;  // the bytes of its trajectories
  };
  static const Run& run() {
    static const Run made = [] {
      System system(claimed(), options(), vocabulary());
      EXPECT_NEAR(off(system), kClaimed - 1, 1e-9);
      const int tracked = track(system, 0, kFrames);
      system.finish();
      EXPECT_EQ(system.map().read()->check(), "");
      EXPECT_EQ(system.camera(), system.map().read()->camera());
      storage::MapHeader header;
      header.camera = claimed();
      header.levels = kFewestLevels;
      header.factor = static_cast<float>(options().orb.scale_factor);
      EXPECT_TRUE(storage::save_map(file(), system.map_state(), header));
      return Run{tracked, off(system), bytes(system.trajectory()) + bytes(system.online_trajectory())};
    }();
    return made;
  }
  static std::filesystem::path file() {
    return std::filesystem::path(testing::TempDir()) / ("covis_focal_" + std::to_string(getpid()));
  }
  static void TearDownTestSuite() { std::filesystem::remove(file()); }
  static storage::SavedMap saved() {
    run();
    return std::move(storage::load_map(file()).value());
  }
};

TEST_F(FocalLength, IsRefinedForAllOfTheMapLong) {
  EXPECT_LT(run().off, kLeft);
  EXPECT_GT(run().tracked, kFrames * 7 / 10);
}

// The result must not depend on how often the user waits for mapping, even while an estimate is running.
TEST_F(FocalLength, IsRefinedWhereMappingIsWaitedForLong) {
  constexpr int kEvery = 7;
  System system(claimed(), options(), vocabulary());
  int tracked = 0;
  for (int i = 0; i < kFrames; ++i) {
    tracked += track(system, i, i + 1);
    if (i % kEvery != kEvery - 1) continue;
    system.finish();
    ASSERT_EQ(system.map().read()->check(), "");
  }
  system.finish();
  EXPECT_LT(off(system), kLeft);
  EXPECT_EQ(system.camera(), system.map().read()->camera());
  EXPECT_GT(tracked, kFrames * 7 / 10);
}

// When it is applied depends on the machine, and with it how well it is known.
TEST_F(FocalLength, IsRefinedInRealTime) {
  constexpr double kHalf = 0.02;
  SystemOptions realtime = options();
  realtime.realtime = true;
  System system(camera(1 + 2 * kHalf), realtime, vocabulary());
  for (int i = 0; i < kFrames; ++i) {
    // Locating waits for mapping of the key frame but not for the refinement; without it a slow machine would have a
    // poor map.
    if (system.process(recording().frame(i)).track.key_frame) system.locate(recording().frame(i));
  }
  system.finish();
  EXPECT_EQ(system.map().read()->check(), "");
  EXPECT_LT(off(system), kHalf);
}

TEST(FocalLengthWithDepth, IsRefinedForRgbdNotForStereoLong) {
  constexpr int kShort = 200;
  for (const Sensor sensor : {Sensor::rgbd, Sensor::stereo}) {
    SCOPED_TRACE(sensor_name(sensor));
    Recording recording(sensor, kShort, 10, "posters");
    const Camera claimed = camera_of(recording, kClaimed);
    System system(claimed, options_for(sensor), vocabulary());
    for (int i = 0; i < kShort; ++i)
      EXPECT_EQ(system.process(recording.frame(i)).track.state, TrackingState::tracking) << i;
    system.finish();
    ASSERT_EQ(system.map().read()->check(), "");
    ASSERT_GT(system.map().read()->next_serial(), 25U) << "else it is hardly asked for";
    EXPECT_EQ(system.camera().bf, claimed.pinhole.bf);
    if (sensor == Sensor::stereo) {
      EXPECT_EQ(system.camera(), claimed.pinhole);
    } else {
      EXPECT_LT(std::abs(system.camera().fx / camera_of(recording, 1).pinhole.fx - 1), kLeft);
      // Frames that were tracked before lay between key frames with other ways between them.
      const auto made = system.snapshot();
      const std::vector<PoseOfFrame> key_frames(made->key_frames.begin(), made->key_frames.end());
      EXPECT_LT(error(made->trajectory, recording.synth, false), 1.55 * error(key_frames, recording.synth, false));
    }
  }
}

TEST_F(FocalLength, StaysAsGivenWhenToldToLong) {
  SystemOptions fixed = options();
  fixed.mapper.refine_focal = fixed.mapper.refine_distortion = false;
  System system(claimed(), fixed, vocabulary());
  track(system, 0, kFrames);
  system.finish();
  EXPECT_EQ(system.camera(), claimed().pinhole);
}

// Locating an image changes nothing of the run, whatever mapping does in the background.
TEST_F(FocalLength, LocatingLeavesTheRunAsItIsLong) {
  System system(claimed(), options(), vocabulary());
  int located = 0;
  for (int i = 0; i < kFrames; ++i) {
    track(system, i, i + 1);
    if (i % 4 == 0) located += system.locate(recording().frame(i / 2)).has_value();
  }
  system.finish();
  EXPECT_TRUE(bytes(system.trajectory()) + bytes(system.online_trajectory()) == run().result);
  EXPECT_GT(located, 5);
}

TEST_F(FocalLength, IsKeptWithASavedMapLong) {
  const Pinhole refined = saved().map.camera();
  EXPECT_LT(std::abs(refined.fx / camera(1).pinhole.fx - 1), kLeft);
  for (const bool localize : {false, true}) {
    for (const bool refine : {false, true}) {
      SystemOptions on = options();
      on.localize = localize;
      on.mapper.refine_focal = on.mapper.refine_distortion = refine;
      System system(claimed(), on, vocabulary());
      storage::SavedMap map = saved();
      ASSERT_TRUE(system.set_map(std::move(map.map), map.header.camera));
      EXPECT_EQ(system.camera(), refined) << "it is the map's, whatever may be changed from now on";
      EXPECT_GT(track(system, kFrames - 40, kFrames), 30);
      system.finish();
      EXPECT_LT(off(system), kLeft);
      EXPECT_EQ(system.map().read()->check(), "");
      if (localize || !refine) {
        EXPECT_EQ(system.camera(), refined);
      }
    }
  }
}

// A map that another camera made is expressed in the present one, and is found and continued with it.
TEST_F(FocalLength, OfAnotherCameraIsNotThatOfTheMapAnyMoreLong) {
  const Camera other = camera(1.001);
  for (const bool localize : {false, true}) {
    SystemOptions o = options();
    o.localize = localize;
    System system(other, o, vocabulary());
    std::string said;
    set_log_sink([&](LogLevel, std::string_view text) { said += text; });
    storage::SavedMap map = saved();
    const size_t key_frames = map.map.key_frame_count();
    const auto taken = system.set_map(std::move(map.map), map.header.camera);
    set_log_sink({});
    ASSERT_TRUE(taken) << taken.error().message;
    EXPECT_NE(said.find("fx 255 instead of 250.25"), std::string::npos) << said;
    EXPECT_EQ(system.camera().fx, other.pinhole.fx);
    EXPECT_GT(track(system, kFrames - 40, kFrames), 30);
    EXPECT_TRUE(system.locate(recording().frame(kFrames - 10)));
    EXPECT_EQ(system.map().read()->check(), "");
    if (localize) {
      EXPECT_EQ(system.map().read()->key_frame_count(), key_frames);
    }
  }
}

}  // namespace
}  // namespace covis
