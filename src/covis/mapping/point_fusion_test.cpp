// SPDX-License-Identifier: Apache-2.0
#include "covis/mapping/point_fusion.h"

#include <gtest/gtest.h>

#include "covis/map/test_point_scene.h"

namespace covis {
namespace {

// The last key frame recognised every other point it sees, and took the others for new ones.
TEST(PointFusion, DuplicatesInTheNeighbourhoodAreFused) {
  const PointScene scene = PointScene::wall();
  SceneMap world(scene);
  world.add_key_frames(4);
  const size_t before = world.shared.read()->point_count();
  for (size_t p = 1; p < world.handles.size(); p += 2) world.handles[p] = {};
  world.add_key_frames(1, 3);
  const size_t doubled = world.shared.read()->point_count();
  ASSERT_GT(doubled, before + 100);

  PointFuser fuser;
  const int fused = fuse_neighbours(world.shared, world.frames.back(), Sensor::rgbd, {}, fuser);
  EXPECT_GE(fused, 100);
  const auto map = world.shared.read();
  EXPECT_EQ(map->check(), "");
  EXPECT_LT(map->point_count() - before, (doubled - before) / 10) << "nearly all are found";
  EXPECT_GT(map->weight(world.frames[3], world.frames[4]), 200) << "both see the same now";
}

}  // namespace
}  // namespace covis
