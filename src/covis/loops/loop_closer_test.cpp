// SPDX-License-Identifier: Apache-2.0
#include "covis/loops/loop_closer.h"

#include <gtest/gtest.h>

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
