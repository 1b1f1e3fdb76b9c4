// SPDX-License-Identifier: Apache-2.0
#include "covis/loops/loop_closer.h"

#include <gtest/gtest.h>

#include "covis/loops/loop_correction.h"
#include "covis/loops/test_loop_scene.h"

namespace covis {
namespace {

class LoopCloserTest : public testing::Test {
 protected:
  LoopReport process(Sensor sensor = Sensor::rgbd) {
    LoopCloser closer(around.world.shared, sensor, {}, 0);
    const LoopReport report = closer.process(around.current);
    EXPECT_EQ(around.world.shared.read()->check(), "");
    return report;
  }

  LoopScene around;
};

TEST_F(LoopCloserTest, TakesTheDriftOut) {
  around.go_around();
  const LoopReport report = process();
  ASSERT_EQ(report.outcome, LoopOutcome::closed);
  EXPECT_TRUE(report.changed_map());
  EXPECT_NEAR(report.drift.distance, around.drift.head<3>().norm(), 0.1);
  EXPECT_GT(report.fused, 40);
  const auto map = around.world.shared.read();
  const auto& edges = map->at(around.current).loop_edges;
  EXPECT_TRUE(std::binary_search(edges.begin(), edges.end(), report.loop));
  const size_t last = around.world.frames.size() - 1;
  EXPECT_LT((map->at(around.current).T_cw.centre() - around.scene.T_wc_of(last).t()).norm(), 0.03);
  EXPECT_GT(map->weight(around.current, around.place()), 40) << "they see the same points now";
}

TEST_F(LoopCloserTest, APlaceThatTheKeyFrameSharesPointsWithIsNoLoop) {
  around.world.memory = ~size_t{0};
  around.drift.setZero();
  around.go_around();
  const LoopReport report = process();
  EXPECT_EQ(report.outcome, LoopOutcome::none);
  EXPECT_FALSE(report.loop.valid());
}

TEST_F(LoopCloserTest, WithoutDriftThePointsAreFusedAlone) {
  around.drift.setZero();
  around.go_around();
  const SE3 before = around.world.shared.read()->at(around.current).T_cw;
  const LoopReport report = process();
  EXPECT_EQ(report.outcome, LoopOutcome::fused);
  EXPECT_FALSE(report.changed_map());
  EXPECT_GT(report.fused, 40);
  EXPECT_EQ(around.world.shared.read()->at(around.current).T_cw.t(), before.t());
}

// The pose graph holds the root: it may not start where the loop would have it, nor its points go there.
TEST_F(LoopCloserTest, TheRootStaysThoughItIsBesideTheKeyFrame) {
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
  const Loop loop{LoopPlace(*map, around.place()), LoopRelation::same_submap,
                  Sim3(around.scene.T_cw(around.world.frames.size() - 1)), {}};
  const LoopGraph graph(*map, around.current, loop, Sensor::rgbd);
  ASSERT_EQ(graph.frames.front(), root);
  EXPECT_TRUE(graph.problem.fixed.front());
  EXPECT_EQ(graph.problem.poses.front().t(), graph.before.front().t());
}

TEST_F(LoopCloserTest, JoinsASubmapToTheOlderOne) {
  const SE3 shift = SE3::exp((Vector6d() << 3, 1, -2, 0.1, 0.7, 0.2).finished());
  around.go_twice(12, shift);
  const LoopReport report = process();
  ASSERT_EQ(report.outcome, LoopOutcome::joined);
  EXPECT_EQ(report.joined_key_frames, 12);
  const auto map = around.world.shared.read();
  EXPECT_EQ(map->submaps().size(), 1u);
  for (size_t k = 0; k < 12; ++k) {
    const Eigen::Vector3d centre = map->at(around.world.frames[12 + k]).T_cw.centre();
    EXPECT_LT((centre - around.scene.T_wc_of(k).t()).norm(), 0.03) << k;
  }
}

TEST_F(LoopCloserTest, SoonAfterALoopThereIsNoOther) {
  around.go_around();
  LoopCloser closer(around.world.shared, Sensor::rgbd, {}, 0);
  ASSERT_TRUE(closer.process(around.current).changed_map());
  EXPECT_EQ(closer.process(around.current).candidates, 0);
  closer.reset();
  EXPECT_FALSE(closer.process(around.current).changed_map()) << "it is tied already";
}

}  // namespace
}  // namespace covis
