// SPDX-License-Identifier: Apache-2.0
#include "covis/mapping/recent_points.h"

#include <gtest/gtest.h>

#include "covis/map/test_point_scene.h"

namespace covis {
namespace {

// One key frame whose points are on probation.
struct RecentPointsTest : testing::Test {
  void SetUp() override {
    world.add_key_frames(1);
    points = world.shared.read()->points();
    for (const MapPointId& id : points) recent.add(id, 0);
  }
  int cull(Sensor sensor = Sensor::rgbd) { return recent.cull(world.shared, world.frames.back(), sensor, 0.25); }
  // A key frame that sees none of them.
  void look_elsewhere() {
    world.forget_points();
    world.add_key_frames(1, world.frames.size());
  }

  const PointScene scene = PointScene::wall();
  SceneMap world{scene};
  std::vector<MapPointId> points;
  RecentPoints recent;
};

TEST_F(RecentPointsTest, ThoseRarelyFoundGoAtOnce) {
  world.shared.write()->count_visible(points[0], 20);
  EXPECT_EQ(cull(), 1);
  EXPECT_EQ(world.shared.read()->find(points[0]), nullptr);
  EXPECT_EQ(recent.size(), points.size() - 1);
}

TEST_F(RecentPointsTest, ThoseNotObservedAgainGoAfterTwoKeyFrames) {
  look_elsewhere();
  EXPECT_EQ(cull(), 0);
  look_elsewhere();
  EXPECT_EQ(cull(), static_cast<int>(points.size()))
      << "one observation with depth counts as two, and three are too few";
  EXPECT_EQ(recent.size(), 0u);
}

// They are what the camera is found by when it comes back.
TEST_F(RecentPointsTest, ThoseOfASubmapThatTheCameraLeftStay) {
  const PointScene::View view = scene.view(scene.T_cw(10));
  KeyFrameId elsewhere;
  for (int64_t frame = 50; frame < 53; ++frame) {
    const auto map = world.shared.write();
    elsewhere = frame == 50 ? map->begin_submap(frame, frame, SE3(), view.features)
                            : map->add_key_frame(frame, frame, SE3(), view.features, map->at(elsewhere).submap);
  }
  EXPECT_EQ(recent.cull(world.shared, elsewhere, Sensor::rgbd, 0.25), 0);
  EXPECT_EQ(recent.size(), 0u);
  for (const MapPointId& id : points) EXPECT_NE(world.shared.read()->find(id), nullptr);
}

TEST_F(RecentPointsTest, ThoseObservedAgainStay) {
  world.add_key_frames(3, 0);
  EXPECT_LT(cull(), static_cast<int>(points.size()) / 3);
  EXPECT_EQ(recent.size(), 0u) << "three key frames later none is on probation";
}

// A point that is rarely found is triangulated anew now and then; as it takes the place of the new one, it is not on
// probation.
TEST_F(RecentPointsTest, AnOldPointInTheirPlaceStays) {
  RecentPoints young;
  young.add(points[0], 0);
  {
    const auto map = world.shared.write();
    map->count_visible(points[1], 20);
    map->replace_point(points[0], points[1]);
  }
  EXPECT_EQ(young.cull(world.shared, world.frames.back(), Sensor::rgbd, 0.25), 0);
  EXPECT_EQ(young.size(), 0u);
  EXPECT_NE(world.shared.read()->find(points[1]), nullptr);
}

}  // namespace
}  // namespace covis
