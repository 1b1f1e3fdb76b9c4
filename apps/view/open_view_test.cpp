// SPDX-License-Identifier: Apache-2.0
#include "apps/view/open_view.h"

#include <gmock/gmock.h>

#include "apps/view/test_scene.h"
#include "covis/core/atomic_file.h"
#include "covis/core/test_folder.h"
#include "covis/map/camera_change.h"
#include "covis/storage/test_maps.h"

namespace covis::view {
namespace {

using testing::HasSubstr;

TEST(OpenView, ASavedMapIsShownWithItsCamera) {
  const TemporaryFolder folder;
  const Map map = storage::random_map(1, 60);
  ASSERT_TRUE(storage::save_map(folder / "some.m", map.state(), storage::test_header()));
  const auto state = open_view(folder / "some.m");
  ASSERT_TRUE(state) << state.error().message;
  EXPECT_EQ(state->map->key_frames.size(), map.key_frame_count());
  EXPECT_EQ(state->map->points.size(), map.point_count());
  EXPECT_THAT(state->info, HasSubstr("\"width\":640"));
}

// A map of one camera that another one goes on with: its observations stay in the pixels of the first.
TEST(OpenView, KeyFramesOfAnotherCameraAreShownByIt) {
  const TemporaryFolder folder;
  storage::MapHeader header = storage::test_header();
  MapState map = storage::random_map(1, 60).state();
  const Camera first = header.camera, wide{1280, 720, {900, 901, 640, 360, 72}};
  ASSERT_TRUE(express_in(map, first, {wide, wide.pinhole}));
  header.camera = wide;
  ASSERT_TRUE(storage::save_map(folder / "wide.m", map, header));
  const auto state = open_view(folder / "wide.m");
  ASSERT_TRUE(state) << state.error().message;
  EXPECT_THAT(state->info, HasSubstr("\"width\":1280"));
  EXPECT_THAT(state->map->cameras, testing::ElementsAre(CameraRow{500, 501, 320.5f, 240.25f, 640, 480}));
  for (const KeyFrameRow& row : state->map->key_frames) EXPECT_EQ(row.camera, 1u);
}

TEST(OpenView, AResultIsItsSceneFile) {
  const TemporaryFolder folder;
  ViewState state;
  state.info = "{}";
  state.map = std::make_shared<const MapScene>(scene_of(small_snapshot()));
  ASSERT_TRUE(write_atomically(folder / kSceneFile, file_of(state)));
  const auto opened = open_view(folder.path());
  ASSERT_TRUE(opened) << opened.error().message;
  EXPECT_EQ(opened->map->points, state.map->points);
}

TEST(OpenView, ErrorsSayWhatWouldBeRight) {
  const TemporaryFolder folder;
  EXPECT_THAT(open_view(folder / "none").error().message,
              HasSubstr("none: there is no such file; give a result folder"));
  EXPECT_THAT(open_view(folder.path()).error().message,
              HasSubstr("it has no scene.bin: give a folder that covis run wrote"));
  ASSERT_TRUE(write_atomically(folder / kSceneFile, "COVISVW0"));
  EXPECT_THAT(open_view(folder.path()).error().message, HasSubstr("scene.bin: it does not begin as such a file"));
  ASSERT_TRUE(write_atomically(folder / "note.txt", "no map"));
  EXPECT_THAT(open_view(folder / "note.txt").error().message, HasSubstr("note.txt"));
}

}  // namespace
}  // namespace covis::view
