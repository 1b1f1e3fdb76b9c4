// SPDX-License-Identifier: Apache-2.0
#include "covis/matching/point_set.h"

#include <gtest/gtest.h>

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
  const auto map = world.shared.read();
  const std::vector<MapPointId> points = points_of(*map, std::vector{world.frames[0], world.frames[1], KeyFrameId{}});
  EXPECT_TRUE(std::is_sorted(points.begin(), points.end()));
  EXPECT_EQ(std::adjacent_find(points.begin(), points.end()), points.end());
  EXPECT_LT(points.size(), map->point_count()) << "the third key frame sees new ones";
}

TEST_F(PointSetTest, AnIndexIsFoundByHandle) {
  PointSet points;
  points.id = points_of(*world.shared.read(), world.frames);
  EXPECT_EQ(index_of(points, points.id[17]), 17);
  EXPECT_EQ(index_of(points, MapPointId{99999, 0}), -1);
}

}  // namespace
}  // namespace covis
