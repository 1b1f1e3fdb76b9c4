// SPDX-License-Identifier: Apache-2.0
#include "covis/matching/point_set.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <vector>

#include "covis/map/test_point_scene.h"

namespace covis {
namespace {

struct PointSetTest : testing::Test {
  void SetUp() override { world.add_key_frames(3); }

  const PointScene scene = PointScene::wall();
  SceneMap world{scene};
};

TEST_F(PointSetTest, HoldsWhatTheMapHas) {
  const auto map = world.shared.read();
  PointSet points, added;
  points.id = points_of(*map, world.frames);
  points.copy(*map);
  EXPECT_EQ(points.size(), map->point_count());
  for (size_t k = 0; k < points.size(); ++k) {
    const MapPoint& point = map->at(points.id[k]);
    EXPECT_EQ(points.position(k), point.position_w);
    EXPECT_EQ(points.d_min[k], point.d_min);
    EXPECT_EQ(points.d_max[k], point.d_max);
    EXPECT_EQ(points.nz[k], static_cast<float>(point.normal_w.z()));
    EXPECT_EQ(points.descriptor[k], point.descriptor);
    added.add(points.id[k], point);
  }
  EXPECT_EQ(added.id, points.id);
  EXPECT_TRUE(std::equal(added.px.begin(), added.px.end(), points.px.begin()));
  points.clear();
  EXPECT_TRUE(points.empty());
}

TEST_F(PointSetTest, ListsEachPointOnceInTheOrderOfHandles) {
  for (size_t p = 0; p < world.handles.size(); p += 3) world.shared.write()->erase_point(world.handles[p]);
  world.add(scene.T_cw(3));  // new points in the slots of the erased ones
  world.forget_points();
  world.add(scene.T_cw(4));  // new points alone, in slots of their own
  const auto map = world.shared.read();
  const auto expect_all_of = [&](const std::vector<KeyFrameId>& key_frames) {
    std::set<MapPointId> expected;
    for (const KeyFrameId& key_frame : key_frames) {
      if (!key_frame.valid()) continue;
      for (const MapPointId& point : map->at(key_frame).points) {
        if (point.valid()) expected.insert(point);
      }
    }
    const std::vector<MapPointId> points = points_of(*map, key_frames);
    EXPECT_EQ(points, std::vector<MapPointId>(expected.begin(), expected.end()));
    return points;
  };
  expect_all_of({});
  expect_all_of({KeyFrameId{}});
  const auto old = expect_all_of({world.frames[0], world.frames[1], KeyFrameId{}});
  EXPECT_LT(old.size(), map->point_count()) << "the others see new ones";
  const auto reused = expect_all_of({world.frames[3], world.frames[2], world.frames[3]});
  EXPECT_TRUE(std::any_of(reused.begin(), reused.end(), [](const MapPointId& id) { return id.generation > 0; }));
  EXPECT_GT(expect_all_of({world.frames[4]}).front().slot, 64u);
}

TEST_F(PointSetTest, AnIndexIsFoundByHandle) {
  PointSet points;
  points.id = points_of(*world.shared.read(), world.frames);
  EXPECT_EQ(index_of(points, points.id[17]), 17);
  EXPECT_EQ(index_of(points, MapPointId{99999, 0}), -1);
}

}  // namespace
}  // namespace covis
