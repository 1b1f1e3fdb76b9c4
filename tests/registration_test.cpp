// SPDX-License-Identifier: Apache-2.0
// A depth camera whose images are not registered to those of the other camera: where they show what those show is found
// as the map grows, and known where the map is used again.
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>

#include "covis/storage/map_file.h"
#include "rendered.h"

namespace covis {
namespace {

constexpr int kFrames = 100;
constexpr DepthRegistration kTruth{.scale = 1.1, .shift_x = 4, .shift_y = -3};

// Frames whose depth images are those of a depth camera that turns and moves with the other one.
class UnregisteredDepth : public testing::Test {
 protected:
  static Recording& recording() {
    static Recording& made = shared_recording(Sensor::rgbd, kFrames, 6);
    return made;
  }
  static System::Input frame(int i, ImageF& depth, const DepthRegistration& registration = kTruth) {
    System::Input input = recording().frame(i);
    const ImageView<const float> registered = input.depth;
    const Pinhole& camera = recording().synth.camera().pinhole;
    const Eigen::Vector2d centre(camera.cx, camera.cy), shift(registration.shift_x, registration.shift_y);
    depth = ImageF(registered.width, registered.height);
    for (int v = 0; v < registered.height; ++v) {
      for (int u = 0; u < registered.width; ++u) {
        const Eigen::Vector2d at = centre + (Eigen::Vector2d(u, v) - shift - centre) / registration.scale;
        const int x = static_cast<int>(std::lround(at.x())), y = static_cast<int>(std::lround(at.y()));
        const bool within = x >= 0 && y >= 0 && x < registered.width && y < registered.height;
        depth(u, v) = within ? registered(x, y) : 0;
      }
    }
    input.depth = depth.view();
    return input;
  }
  static int track(System& system, int from, int to, const DepthRegistration& registration = kTruth) {
    int tracked = 0;
    ImageF depth;
    for (int i = from; i < to; ++i)
      tracked += system.process(frame(i, depth, registration)).track.state == TrackingState::tracking;
    system.finish();
    return tracked;
  }
  static double error(const System& system) {
    return error_to(
        system.trajectory(), [](int64_t i) { return recording().synth.T_wc(static_cast<int>(i)); }, false);
  }
  static SystemOptions options(bool registers = true) {
    SystemOptions made = options_for(Sensor::rgbd);
    made.mapper.register_depth = registers;
    return made;
  }
  // A run of all frames, made once for all cases.
  static const System& run() {
    static System system(recording().synth.camera(), options(), vocabulary());
    static const int tracked = track(system, 0, kFrames);
    EXPECT_EQ(tracked, kFrames);
    return system;
  }
  static void expect_found(const DepthRegistration& found) {
    EXPECT_NEAR(found.scale, kTruth.scale, 0.01);
    const Eigen::Vector2d centre(160, 120), corner(300, 220);
    EXPECT_LT((found.pixel(corner, centre, 0.3) - kTruth.pixel(corner, centre, 0.3)).norm(), 3);
  }
};

TEST_F(UnregisteredDepth, IsFound) {
  expect_found(run().camera().registration);
  EXPECT_EQ(run().map().read()->check(), "");
}

TEST_F(UnregisteredDepth, IsLeftWhenToldToLong) {
  System without(recording().synth.camera(), options(false), vocabulary());
  track(without, 0, kFrames);
  EXPECT_FALSE(without.camera().registration.any());
  EXPECT_LT(error(run()), 0.7 * error(without));
}

TEST_F(UnregisteredDepth, ThatWasGivenIsNotLookedForLong) {
  Camera camera = recording().synth.camera();
  camera.pinhole.registration = kTruth;
  System system(camera, options(), vocabulary());
  track(system, 0, kFrames);
  EXPECT_EQ(system.camera().registration, kTruth);
  EXPECT_LT(error(system), error(run()));
  const auto map = system.map().read();
  const Features& first = *map->at(map->root()).features;
  EXPECT_FALSE(first.kept_depth);
  ImageF depth;
  Frontend frontend(camera, options().orb, Sensor::rgbd);
  const System::Input input = frame(0, depth);
  const FeaturesPtr right = frontend.rgbd(input.image, input.depth);
  EXPECT_GT(right->size(), 100);
  EXPECT_EQ(first.depth, right->depth) << "from the first frame on";
}

TEST_F(UnregisteredDepth, IsKeptWithASavedMapLong) {
  const auto file = std::filesystem::path(testing::TempDir()) / ("covis_registration_" + std::to_string(getpid()));
  storage::MapHeader header;
  header.camera = recording().synth.camera();
  header.sensor = Sensor::rgbd;
  header.levels = kFewestLevels;
  header.factor = static_cast<float>(options().orb.scale_factor);
  ASSERT_TRUE(storage::save_map(file, run().map_state(), header));
  auto saved = storage::load_map(file);
  ASSERT_TRUE(saved) << saved.error().message;
  System system(recording().synth.camera(), options(), vocabulary());
  ASSERT_TRUE(system.set_map(std::move(saved->map), saved->header.camera));
  EXPECT_EQ(system.camera().registration, run().camera().registration);
  EXPECT_GT(track(system, kFrames - 30, kFrames), 25);
  EXPECT_EQ(system.camera().registration, run().camera().registration);
  std::filesystem::remove(file);
}

TEST_F(UnregisteredDepth, RegisteredDepthIsLeftAloneLong) {
  System system(recording().synth.camera(), options(), vocabulary());
  EXPECT_EQ(track(system, 0, kFrames, {}), kFrames);
  EXPECT_FALSE(system.camera().registration.any());
}

}  // namespace
}  // namespace covis
