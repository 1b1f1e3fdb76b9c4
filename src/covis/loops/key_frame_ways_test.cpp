// SPDX-License-Identifier: Apache-2.0
#include "covis/loops/key_frame_ways.h"

#include <gtest/gtest.h>

#include <cmath>

#include "covis/loops/test_loop_scene.h"

namespace covis {
namespace {

TEST(KeyFrameWays, TheWayLeadsAlongTheGraph) {
  const PointScene scene = PointScene::ring(2400, LoopScene::kSteps);
  SceneMap world(scene, Sensor::rgbd);
  for (size_t k = 0; k < 24; ++k) world.add(scene.T_cw(k), scene.T_cw(k));
  world.begin_submap();
  for (size_t k = 0; k < 4; ++k) world.add(scene.T_cw(k), scene.T_cw(k));
  const auto map = world.shared.read();
  const KeyFrameWays ways(*map);
  const std::vector<double> way = ways.from(world.frames[0]);
  ASSERT_EQ(way.size(), 28u);
  EXPECT_EQ(way[world.frames[0].slot], 0);
  const double chord = (map->at(world.frames[23]).T_cw.centre() - map->at(world.frames[0]).T_cw.centre()).norm();
  EXPECT_GT(way[world.frames[23].slot], 1.2 * chord) << "around the ring, not across it";
  EXPECT_LT(way[world.frames[23].slot], 3.2 * 2);
  EXPECT_TRUE(std::isinf(way[world.frames[24].slot])) << "another submap";
  EXPECT_NEAR(ways.from(world.frames[23])[world.frames[0].slot], way[world.frames[23].slot], 1e-9) << "the way back";
  const std::vector<double> near = ways.from(world.frames[0], 1.5);
  for (size_t k = 0; k < near.size(); ++k) EXPECT_EQ(near[k], way[k] <= 1.5 ? way[k] : INFINITY);
}

TEST(KeyFrameWays, SlotsOfErasedKeyFramesLeadNowhere) {
  const PointScene scene = PointScene::ring(2400, LoopScene::kSteps);
  SceneMap world(scene, Sensor::rgbd);
  for (size_t k = 0; k < 6; ++k) world.add(scene.T_cw(k), scene.T_cw(k));
  ASSERT_TRUE(world.shared.write()->erase_key_frame(world.frames[2]));
  const std::vector<double> way = KeyFrameWays(*world.shared.read()).from(world.frames[0]);
  EXPECT_TRUE(std::isinf(way[world.frames[2].slot]));
  EXPECT_TRUE(std::isfinite(way[world.frames[5].slot]));
}

}  // namespace
}  // namespace covis
