// SPDX-License-Identifier: Apache-2.0
#include "covis/loops/loop_correction.h"

#include <gtest/gtest.h>

#include "covis/loops/test_loop_scene.h"

namespace covis {
namespace {

struct LoopCorrectionTest : testing::Test {
  void SetUp() override { around.go_around(); }
  // The loop as it should be found, without the points found again.
  Loop true_loop(const Map& map) {
    return {LoopPlace(map, around.place()),
            LoopRelation::same_submap,
            Sim3(around.scene.T_cw(around.world.frames.size() - 1)),
            {}};
  }

  LoopScene around;
};

// The pose graph holds the root: it may not start where the loop would have it, nor its points go there.
TEST_F(LoopCorrectionTest, TheRootStaysThoughItIsBesideTheKeyFrame) {
  around.go_around();
  const KeyFrameId root = around.world.frames.front();
  {
    // Points that root and current share by mistake make them covisible.
    const auto map = around.world.shared.write();
    uint32_t shared = 0;
    for (uint32_t f = 0; f < map->at(root).points.size() && shared < 30; ++f) {
      const MapPointId point = map->at(root).points[f];
      const uint32_t other = static_cast<uint32_t>(map->at(around.current).points.size()) - 1 - shared;
      if (!point.valid() || map->at(point).observations.size() < 3) continue;
      map->erase_observation(map->at(around.current).points[other], around.current);
      shared += map->add_observation(point, around.current, other);
    }
    ASSERT_GE(map->weight(root, around.current), kCovisibilityThreshold);
  }
  const auto map = around.world.shared.read();
  const LoopGraph graph(*map, around.current, true_loop(*map), Sensor::rgbd);
  ASSERT_EQ(graph.frames.front(), root);
  EXPECT_TRUE(graph.problem.fixed.front());
  EXPECT_EQ(graph.problem.poses.front().t(), graph.before.front().t());
}

TEST_F(LoopCorrectionTest, ThePointsOfTheRootStayToo) {
  const KeyFrameId root = around.world.frames.front();
  const Loop loop = true_loop(*around.world.shared.read());
  std::vector<std::pair<MapPointId, Eigen::Vector3d>> before;
  around.world.shared.read()->for_each_point([&](MapPointId id, const MapPoint& point) {
    if (point.reference == root) before.emplace_back(id, point.position_w);
  });
  ASSERT_GT(before.size(), 100u);
  correct_loop(around.world.shared, around.current, loop, Sensor::rgbd);
  const auto map = around.world.shared.read();
  EXPECT_EQ(map->check(), "");
  EXPECT_EQ(map->at(root).T_cw.t(), around.scene.T_cw(0).t());
  for (const auto& [id, position] : before) EXPECT_LT((map->at(id).position_w - position).norm(), 1e-9);
  const size_t last = around.world.frames.size() - 1;
  EXPECT_LT((map->at(around.current).T_cw.centre() - around.scene.T_wc_of(last).t()).norm(), 0.03);
}

}  // namespace
}  // namespace covis
