// SPDX-License-Identifier: Apache-2.0
#include "covis/mapping/local_adjustment.h"

#include <gtest/gtest.h>

#include "covis/map/test_point_scene.h"

namespace covis {
namespace {

struct LocalAdjustmentTest : testing::Test {
  void SetUp() override { world.add_key_frames(12); }

  const PointScene scene = PointScene::wall();
  SceneMap world{scene};
  BundleAdjuster adjuster;
};

TEST_F(LocalAdjustmentTest, TheWindowIsTheBestNeighboursAndThoseThatHoldThem) {
  const LocalWindow window = local_window(*world.shared.read(), world.frames.back(), 4, 3);
  EXPECT_EQ(window.moving, 4u);
  ASSERT_EQ(window.key_frames.size(), 7u);
  for (size_t k = 0; k < 4; ++k)
    EXPECT_EQ(window.key_frames[k], world.frames[11 - k]) << "the nearer, the more is shared";
  for (size_t k = 4; k < 7; ++k) EXPECT_EQ(window.key_frames[k], world.frames[11 - k]);
}

TEST_F(LocalAdjustmentTest, BringsADisturbedKeyFrameBack) {
  world.shared.write()->set_pose(world.frames[11],
                                 SE3::exp((Vector6d() << 0.01, 0.01, 0, 0.002, 0, 0).finished()) * scene.T_cw(11));
  const AdjustmentReport report = adjust_locally(world.shared, world.frames[11], {}, adjuster, nullptr, nullptr);
  EXPECT_GT(report.observations, 500);
  EXPECT_FALSE(report.interrupted);
  const auto map = world.shared.read();
  EXPECT_EQ(map->check(), "");
  EXPECT_LT((map->at(world.frames[11]).T_cw * scene.T_wc_of(11)).log().norm(), 1e-3);
}

// Without the root and with no key frame to hold it, the one that shares fewest points stays.
TEST_F(LocalAdjustmentTest, OneKeyFrameStaysWhenNoneHoldsTheWindow) {
  MapperOptions options;
  options.ba_key_frames = 4;
  options.ba_fixed_key_frames = 0;
  const SE3 before = world.shared.read()->at(world.frames[8]).T_cw;
  world.shared.write()->set_pose(world.frames[11],
                                 SE3::exp((Vector6d() << 0.01, 0, 0, 0, 0, 0).finished()) * scene.T_cw(11));
  adjust_locally(world.shared, world.frames[11], options, adjuster, nullptr, nullptr);
  EXPECT_EQ(world.shared.read()->at(world.frames[8]).T_cw.t(), before.t());
}

}  // namespace
}  // namespace covis
