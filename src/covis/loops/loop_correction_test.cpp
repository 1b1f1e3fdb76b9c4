// SPDX-License-Identifier: Apache-2.0
#include "covis/loops/loop_correction.h"

#include <gtest/gtest.h>

#include <algorithm>

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

TEST_F(LoopCorrectionTest, PointsFusedTieMoreKeyFrames) {
  const Loop loop = true_loop(*around.world.shared.read());
  LoopGraph graph(*around.world.shared.read(), around.current, loop, Sensor::rgbd);
  const size_t before = graph.problem().edges.size();
  EXPECT_EQ(graph.tie(*around.world.shared.read()), 0) << "nothing is fused yet";
  graph.move_beside_loop(around.world.shared);
  PointFuser fuser;
  EXPECT_GT(fuse_loop(around.world.shared, around.current, loop, fuser), 40);
  const auto map = around.world.shared.read();
  const int tied = graph.tie(*map);
  EXPECT_GT(tied, 5);
  ASSERT_EQ(graph.problem().edges.size(), before + static_cast<size_t>(tied));
  for (size_t e = before; e < graph.problem().edges.size(); ++e) {
    const PoseGraphEdge& edge = graph.problem().edges[e];
    const KeyFrameId i = graph.frames()[static_cast<size_t>(edge.i)], j = graph.frames()[static_cast<size_t>(edge.j)];
    EXPECT_GE(map->weight(i, j), kCovisibilityThreshold);
    const SE3 motion = around.scene.T_cw(static_cast<size_t>(map->at(j).frame)) *
                       around.scene.T_wc_of(static_cast<size_t>(map->at(i).frame));
    EXPECT_LT((edge.S_ji.as_pose() * motion.inverse()).log().norm(), 0.15) << "as the loop has them";
  }
}

// A ring that hangs together by few points in one place alone: that place takes the whole correction.
TEST(LoopGraph, BendsAtAWeakLinkFirst) {
  constexpr size_t kBreak = 20, kCount = LoopScene::kSteps + 4;
  LoopScene broken;
  const SE3 wrong = SE3::exp((Vector6d() << 1, 0, 2, 0, 0.5, 0).finished());
  for (size_t i = 0; i < kCount; ++i) {
    if (i == kBreak) broken.world.forget_points();
    const SE3 T = broken.scene.T_cw(i);
    broken.current = broken.world.add(T, i < kBreak ? T : T * wrong);
  }
  const auto error_after = [&](int weak_link) {
    const auto map = broken.world.shared.read();
    const Loop loop{
        LoopPlace(*map, broken.place()), LoopRelation::same_submap, Sim3(broken.scene.T_cw(kCount - 1)), {}};
    LoopGraph graph(*map, broken.current, loop, Sensor::rgbd, weak_link);
    EXPECT_TRUE(graph.solve());
    double worst = 0;
    for (size_t k = 0; k < graph.frames().size(); ++k)
      worst = std::max(worst, (graph.problem().poses[k].as_pose().centre() - broken.scene.T_wc_of(k).t()).norm());
    return worst;
  };
  EXPECT_LT(error_after(60), 0.05);
  EXPECT_GT(error_after(0), 0.3) << "spread over all of them";
}

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
  ASSERT_EQ(graph.frames().front(), root);
  EXPECT_TRUE(graph.problem().fixed.front());
  EXPECT_EQ(graph.problem().poses.front().t(), map->at(root).T_cw.t());
}

TEST_F(LoopCorrectionTest, ThePointsOfTheRootStayToo) {
  const KeyFrameId root = around.world.frames.front();
  const Loop loop = true_loop(*around.world.shared.read());
  std::vector<std::pair<MapPointId, Eigen::Vector3d>> before;
  around.world.shared.read()->for_each_point([&](MapPointId id, const MapPoint& point) {
    if (point.reference == root) before.emplace_back(id, point.position_w);
  });
  ASSERT_GT(before.size(), 100u);
  PointFuser fuser;
  correct_loop(around.world.shared, around.current, loop, Sensor::rgbd, fuser);
  const auto map = around.world.shared.read();
  EXPECT_EQ(map->check(), "");
  EXPECT_EQ(map->at(root).T_cw.t(), around.scene.T_cw(0).t());
  for (const auto& [id, position] : before) EXPECT_LT((map->at(id).position_w - position).norm(), 1e-9);
  const size_t last = around.world.frames.size() - 1;
  EXPECT_LT((map->at(around.current).T_cw.centre() - around.scene.T_wc_of(last).t()).norm(), 0.03);
}

}  // namespace
}  // namespace covis
