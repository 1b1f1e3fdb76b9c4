// SPDX-License-Identifier: Apache-2.0
#include "covis/loops/link_strength.h"

#include <gtest/gtest.h>

#include <limits>

#include "covis/map/test_point_scene.h"

namespace covis {
namespace {

TEST(LinkStrength, CountsThePointsThatBothSidesObserve) {
  const PointScene scene = PointScene::wall();
  SceneMap world(scene);
  world.add_key_frames(5);
  const auto map = world.shared.read();
  int expected = 0;
  map->for_each_point([&](MapPointId, const MapPoint& point) {
    bool early = false, late = false;
    for (const Observation& o : point.observations) (map->at(o.key_frame).serial <= 1 ? early : late) = true;
    expected += early && late;
  });
  const LinkStrength links(*map, 0);
  EXPECT_GT(expected, 100);
  EXPECT_EQ(links.weakest(1, 2), expected);
  EXPECT_EQ(links.weakest(2, 1), expected) << "in either order";
  EXPECT_EQ(links.weakest(2, 2), std::numeric_limits<int>::max()) << "nothing lies between";
}

TEST(LinkStrength, FindsTheWeakestAlongTheWay) {
  const PointScene scene = PointScene::wall();
  SceneMap world(scene);
  world.add_key_frames(4);
  world.forget_points();
  world.add_key_frames(4, 4);
  const auto map = world.shared.read();
  const LinkStrength links(*map, 0);
  EXPECT_EQ(links.weakest(0, 7), 0) << "nothing is seen from both sides";
  EXPECT_GT(links.weakest(0, 3), 100);
  EXPECT_GT(links.weakest(4, 7), 100);
}

TEST(LinkStrength, OtherSubmapsDoNotCount) {
  const PointScene scene = PointScene::wall();
  SceneMap world(scene);
  world.add_key_frames(3);
  world.begin_submap();
  world.add_key_frames(3);
  const auto map = world.shared.read();
  EXPECT_EQ(LinkStrength(*map, 0).weakest(0, 2), LinkStrength(*map, 1).weakest(3, 5));
}

}  // namespace
}  // namespace covis
