// SPDX-License-Identifier: Apache-2.0
// A stereo pair whose right camera is turned a little from where its file has it: rows and columns are found, and known
// where the map is used again.
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>

#include "covis/storage/map_file.h"
#include "rendered.h"

namespace covis {
namespace {

constexpr int kFrames = 90;

Recording& turned_pair() {
  static Recording made([] {
    SynthOptions options;
    options.world = "street";
    options.sensor = "stereo";
    options.frames = kFrames;
    options.width = 480;
    options.height = 240;
    options.noise = 2;
    options.right_yaw = 0.04;
    options.right_pitch = 0.1;
    options.right_roll = 0.1;
    return options;
  }());
  return made;
}

SystemOptions options(bool refines) {
  SystemOptions made = options_for(Sensor::stereo);
  made.orb.refine_rows = made.mapper.refine_distortion = refines;
  return made;
}

int track(System& system, int from, int to) {
  int tracked = 0;
  for (int i = from; i < to; ++i)
    tracked += system.process(turned_pair().frame(i)).track.state == TrackingState::tracking;
  system.finish();
  return tracked;
}

double error(const System& system) {
  return error_to(
      system.trajectory(), [](int64_t i) { return turned_pair().synth.T_wc(static_cast<int>(i)); }, false);
}

TEST(TurnedPair, IsRectifiedAsItIsSeenLong) {
  const Camera camera = turned_pair().synth.camera();
  System plain(camera, options(false), vocabulary()), refined(camera, options(true), vocabulary());
  EXPECT_EQ(track(plain, 0, kFrames), kFrames);
  EXPECT_EQ(track(refined, 0, kFrames), kFrames);
  RecordProperty("plain_mm", static_cast<int>(1000 * error(plain)));
  RecordProperty("refined_mm", static_cast<int>(1000 * error(refined)));
  EXPECT_FALSE(plain.map_state().camera.right_columns.any());
  const ShiftField columns = refined.map_state().camera.right_columns;
  ASSERT_TRUE(columns.any());
  EXPECT_LT(error(refined), 0.7 * error(plain));

  const auto file = std::filesystem::path(testing::TempDir()) / ("covis_pair_" + std::to_string(getpid()));
  storage::MapHeader header;
  header.camera = camera;
  header.sensor = Sensor::stereo;
  header.levels = kFewestLevels;
  header.factor = static_cast<float>(options(true).orb.scale_factor);
  ASSERT_TRUE(storage::save_map(file, refined.map_state(), header));
  auto loaded = storage::load_map(file);
  std::filesystem::remove(file);
  ASSERT_TRUE(loaded) << loaded.error().message;
  SystemOptions localises = options(true);
  localises.localize = true;
  System again(camera, localises, vocabulary());
  ASSERT_TRUE(again.set_map(std::move(loaded->map), camera));
  EXPECT_GT(track(again, 40, 60), 15);
  EXPECT_EQ(again.map_state().camera.right_columns, columns);
}

}  // namespace
}  // namespace covis
