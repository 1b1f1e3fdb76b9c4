// SPDX-License-Identifier: Apache-2.0
// The full bundle adjustment beside other work on the map.
#include "covis/loops/submap_adjustment.h"

#include <gtest/gtest.h>

#include "covis/core/random.h"
#include "covis/map/test_point_scene.h"

namespace covis {
namespace {

// Twenty key frames along a line, every one but the root off its place.
struct FullAdjustmentTest : testing::Test {
  void SetUp() override {
    world.add_key_frames(20);
    Random random(2);
    const auto m = world.shared.write();
    for (size_t k = 1; k < world.frames.size(); ++k) {
      Vector6d xi;
      for (int i = 0; i < 6; ++i) xi(i) = random.uniform(-0.02, 0.02);
      m->set_pose(world.frames[k], SE3::exp(xi) * scene.T_cw(k));
    }
  }

  const PointScene scene = PointScene::wall(800);
  SceneMap world{scene};
  BackgroundAdjustment background;
};

TEST_F(FullAdjustmentTest, AppliesItsResultBesideNewWork) {
  background.start(FullAdjustment::of(*world.shared.read(), world.frames.front(), 20), 1);
  // Meanwhile a key frame goes, and one comes that is a child of the last.
  KeyFrameId fresh;
  SE3 T_fl;  // from the last to it
  {
    const auto m = world.shared.write();
    ASSERT_TRUE(m->erase_key_frame(world.frames[7]));
    const KeyFrameId last = world.frames.back();
    T_fl = SE3::exp((Vector6d() << 0.1, 0, 0, 0, 0.05, 0).finished());
    fresh = m->add_key_frame(99, 99, T_fl * m->at(last).T_cw, m->at(last).features);
    m->attach_to_tree(fresh);
    ASSERT_EQ(m->at(fresh).parent, last);
  }
  const uint64_t moves = world.shared.read()->moves();
  const BackgroundAdjustment::Outcome outcome = background.apply(world.shared);
  EXPECT_TRUE(outcome.applied);
  EXPECT_EQ(outcome.kind, AdjustmentKind::full);
  const auto m = world.shared.read();
  EXPECT_GT(m->moves(), moves) << "what was read of the map before does not fit what is read after";
  EXPECT_EQ(m->check(), "");
  for (size_t k = 0; k < world.frames.size(); ++k) {
    if (k == 7) continue;
    const SE3 off = m->at(world.frames[k]).T_cw * scene.T_wc_of(k);
    EXPECT_LT(off.log().norm(), 1e-3) << "key frame " << k;
  }
  const SE3 relative = m->at(fresh).T_cw * m->at(world.frames.back()).T_cw.inverse();
  EXPECT_LT((relative * T_fl.inverse()).log().norm(), 1e-9) << "what came meanwhile keeps its place beside its parent";
}

TEST_F(FullAdjustmentTest, IsGivenUpAtAnyTime) {
  const SE3 before = world.shared.read()->at(world.frames[3]).T_cw;
  const auto job = [&] { return FullAdjustment::of(*world.shared.read(), world.frames.front(), 1000); };
  for (int k = 0; k < 20; ++k) {
    BackgroundAdjustment other;
    other.start(job(), 1);
    if (k % 2) other.abandon();
    if (k % 4 == 1) other.start(job(), 1);
  }
  EXPECT_EQ(world.shared.read()->at(world.frames[3]).T_cw.t(), before.t());
}

TEST_F(FullAdjustmentTest, ASubmapGivenUpMeanwhileStaysGone) {
  background.start(FullAdjustment::of(*world.shared.read(), world.frames.front(), 20), 1);
  ASSERT_TRUE(world.shared.write()->erase_submap(0));
  EXPECT_FALSE(background.apply(world.shared).applied);
  EXPECT_EQ(world.shared.read()->key_frame_count(), 0u);
}

TEST(FullAdjustment, ThereIsNoneOfASingleKeyFrame) {
  const PointScene scene = PointScene::wall();
  SceneMap world(scene);
  world.add_key_frames(1);
  EXPECT_EQ(FullAdjustment::of(*world.shared.read(), world.frames.front(), 20), nullptr);
}

}  // namespace
}  // namespace covis
