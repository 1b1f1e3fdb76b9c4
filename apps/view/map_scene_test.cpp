// SPDX-License-Identifier: Apache-2.0
#include "apps/view/map_scene.h"

#include <gmock/gmock.h>

#include "apps/view/test_scene.h"

namespace covis::view {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;
using testing::SizeIs;

TEST(MapScene, KeyFramesAreNamedByTheirSerialsAndPointsByTheirSlots) {
  const MapScene scene = scene_of(small_snapshot());
  ASSERT_THAT(scene.key_frames, SizeIs(2));
  EXPECT_EQ(scene.key_frames[0].id, 10u);
  EXPECT_EQ(scene.key_frames[0].parent, kNone);
  EXPECT_EQ(scene.key_frames[1].id, 15u);
  EXPECT_EQ(scene.key_frames[1].parent, 10u);
  EXPECT_FLOAT_EQ(scene.key_frames[1].pose.t[0], 1);
  ASSERT_THAT(scene.points, SizeIs(3));
  EXPECT_EQ(scene.points[2].id, 4u);
  EXPECT_THAT(scene.edges, ElementsAre(EdgeRow{10, 15, 20, 1}));
  EXPECT_THAT(scene.path, SizeIs(4));
}

TEST(MapScene, KeyFramesOfOtherCamerasNameThem) {
  Snapshot snapshot = small_snapshot();
  snapshot.other_cameras = {{{1280, 720, {900, 901, 640, 360}}, {890, 891, 640, 360}}};
  snapshot.key_frames[1].camera = 1;
  const MapScene scene = scene_of(snapshot);
  EXPECT_EQ(scene.key_frames[0].camera, 0u);
  EXPECT_EQ(scene.key_frames[1].camera, 1u);
  EXPECT_THAT(scene.cameras, ElementsAre(CameraRow{900, 901, 640, 360, 1280, 720}));
}

TEST(MapScene, APointBeginsWithTheFirstKeyFrameThatObservesIt) {
  const MapScene scene = scene_of(small_snapshot());
  EXPECT_EQ(scene.points[0].frame, 0);
  EXPECT_EQ(scene.points[1].frame, 0);
  EXPECT_EQ(scene.points[2].frame, 3);
}

TEST(MapScene, ObservationsAreFoundFromBothSides) {
  const MapScene scene = scene_of(small_snapshot());
  EXPECT_THAT(observations_of_key_frame(scene, 10),
              ElementsAre(ObservationRow{0, 41, 82}, ObservationRow{2, 120, 160}));
  EXPECT_THAT(observations_of_point(scene, 2), ElementsAre(ObservationRow{10, 120, 160}, ObservationRow{15, 200, 240}));
  EXPECT_THAT(observations_of_key_frame(scene, 11), IsEmpty());
  EXPECT_THAT(observations_of_point(scene, 99), IsEmpty());
}

}  // namespace
}  // namespace covis::view
