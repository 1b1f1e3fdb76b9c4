// SPDX-License-Identifier: Apache-2.0
#include "covis/mapping/key_frame_culling.h"

#include <gtest/gtest.h>

#include "covis/map/test_point_scene.h"

namespace covis {
namespace {

// Seven key frames that nearly stand still: all between the first and the last are redundant.
struct KeyFrameCullingTest : testing::Test {
  static constexpr CloseDepth kCloseDepth{100};  // beyond all points
  void SetUp() override {
    for (int k = 0; k < 7; ++k) world.add(scene.T_cw(0));
  }
  int cull(double max_redundancy, Sensor sensor = Sensor::rgbd, CloseDepth close_depth = kCloseDepth) {
    return cull_key_frames(world.shared, world.frames.back(), sensor, max_redundancy, close_depth);
  }

  const PointScene scene = PointScene::wall();
  SceneMap world{scene};
};

TEST_F(KeyFrameCullingTest, RedundantOnesGoUntilThePointsAreSeenByFew) {
  EXPECT_EQ(cull(1), 0) << "more than all";
  EXPECT_EQ(cull(0.999), 4) << "then three others no longer see the points of those left";
  const auto map = world.shared.read();
  EXPECT_TRUE(map->find(world.frames.front())) << "the root stays";
  EXPECT_TRUE(map->find(world.frames.back())) << "and so does the new one";
  EXPECT_EQ(map->check(), "");
}

TEST_F(KeyFrameCullingTest, ThoseLeftHaveNoRedundantPoint) {
  EXPECT_EQ(cull(0.9), 4);
  EXPECT_EQ(cull(0), 0);
}

TEST_F(KeyFrameCullingTest, FarPointsDoNotCountWithADepthSensor) {
  EXPECT_EQ(cull(0, Sensor::rgbd, CloseDepth{10}), 0) << "all are beyond a metre";
  EXPECT_EQ(cull(0.999, Sensor::monocular, CloseDepth{10}), 4);
}

// Its loop edge is what the next pose graph knows of the loop.
TEST_F(KeyFrameCullingTest, AKeyFrameWithALoopEdgeStays) {
  world.shared.write()->add_loop_edge(world.frames[2], world.frames[4]);
  cull(0.9);
  const auto map = world.shared.read();
  ASSERT_TRUE(map->find(world.frames[2]));
  ASSERT_TRUE(map->find(world.frames[4]));
  EXPECT_EQ(map->at(world.frames[2]).loop_edges, std::vector{world.frames[4]});
  EXPECT_EQ(map->check(), "");
}

}  // namespace
}  // namespace covis
