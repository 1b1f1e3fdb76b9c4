// SPDX-License-Identifier: Apache-2.0
#include "covis/map/relative_pose.h"

#include <gtest/gtest.h>

#include "covis/map/test_map.h"

namespace covis {
namespace {

struct RelativePoseTest : testing::Test {
  void SetUp() override {
    root = f.frame(0);
    middle = f.frame(1);
    f.link(root, middle, 30, 0);
    pose = RelativePose::of(f.map, camera, middle);
  }

  MapFixture f;
  KeyFrameId root, middle;
  const SE3 camera = pose_at(1.5);
  RelativePose pose;
};

TEST_F(RelativePoseTest, MovesWithItsReference) {
  EXPECT_LT((pose.T_cw(f.map).t() - camera.t()).norm(), 1e-12);
  f.map.set_pose(middle, pose_at(3));
  EXPECT_LT((pose.T_cw(f.map).t() - pose_at(3.5).t()).norm(), 1e-12);
}

TEST_F(RelativePoseTest, IsResolvedToTheNearestLivingAncestor) {
  ASSERT_TRUE(f.map.erase_key_frame(middle));
  const auto resolved = pose.resolved(f.map);
  ASSERT_TRUE(resolved);
  EXPECT_EQ(resolved->key_frame, root);
  EXPECT_LT((resolved->T_cw(f.map).t() - camera.t()).norm(), 1e-12);
}

TEST_F(RelativePoseTest, ItsLengthsGrowWithThoseAroundItsReference) {
  f.map.correct_pose(middle, f.map.at(middle).T_cw, 2);
  EXPECT_EQ(pose.growth(f.map), 2);
  const auto resolved = pose.resolved(f.map);
  ASSERT_TRUE(resolved);
  EXPECT_LT((resolved->T_cr.t() - 2 * pose.T_cr.t()).norm(), 1e-12);
}

TEST_F(RelativePoseTest, ThereIsNoneBesideAKeyFrameThatNeverWas) {
  pose.key_frame = {77, 3};
  EXPECT_FALSE(pose.resolved(f.map));
  EXPECT_EQ(pose.growth(f.map), 1);
}

TEST_F(RelativePoseTest, AKeyFrameRelativeToItself) {
  EXPECT_EQ(RelativePose::at(f.map, middle).T_cw(f.map).t(), f.map.at(middle).T_cw.t());
}

}  // namespace
}  // namespace covis
