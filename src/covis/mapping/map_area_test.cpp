// SPDX-License-Identifier: Apache-2.0
#include "covis/mapping/map_area.h"

#include <gtest/gtest.h>

#include "covis/map/test_point_scene.h"

namespace covis {
namespace {

TEST(MapArea, LeavesTheKeyFramesInsideAndWhatTheySee) {
  const PointScene scene = PointScene::wall();
  SceneMap world(scene);
  world.add_key_frames(12);
  const auto map = world.shared.read();
  const double middle = map->at(world.frames[6]).T_cw.centre().x();
  const auto part = part_of(*map, [&](const Eigen::Vector3d& p) { return p.x() >= middle; });
  ASSERT_TRUE(part) << part.error().message;
  EXPECT_EQ(part->check(), "");
  EXPECT_EQ(part->submaps().size(), 1u);
  EXPECT_EQ(part->key_frame_count(), 6u);
  EXPECT_GT(part->point_count(), 0u);
  EXPECT_LT(part->point_count(), map->point_count());
  for (const KeyFrameId& id : part->key_frames()) EXPECT_GE(part->at(id).T_cw.centre().x(), middle);
  EXPECT_EQ(part->at(part->root()).frame, map->at(world.frames[6]).frame) << "the oldest is the root now";
  EXPECT_EQ(map->key_frame_count(), 12u);
}

TEST(MapArea, TwoPiecesOfOneMapStayOne) {
  const PointScene scene = PointScene::wall();
  SceneMap world(scene);
  world.add_key_frames(12);
  const auto map = world.shared.read();
  const double first = map->at(world.frames[0]).T_cw.centre().x(), last = map->at(world.frames[11]).T_cw.centre().x();
  const auto part = part_of(*map, [&](const Eigen::Vector3d& p) { return p.x() <= first || p.x() >= last; });
  ASSERT_TRUE(part) << part.error().message;
  EXPECT_EQ(part->check(), "");
  EXPECT_EQ(part->submaps().size(), 1u);
  EXPECT_EQ(part->key_frame_count(), 2u);
}

TEST(MapArea, AnAreaWithoutKeyFramesIsRefused) {
  const PointScene scene = PointScene::wall();
  SceneMap world(scene);
  world.add_key_frames(3);
  EXPECT_FALSE(part_of(*world.shared.read(), [](const Eigen::Vector3d&) { return false; }));
}

}  // namespace
}  // namespace covis
