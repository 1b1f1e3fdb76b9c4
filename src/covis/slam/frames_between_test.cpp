// SPDX-License-Identifier: Apache-2.0
#include "covis/slam/frames_between.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <tuple>

#include "covis/map/test_map.h"

namespace covis {
namespace {

// Three key frames along x, a metre from one another, at frames 0, 10 and 20.
class FramesBetweenTest : public testing::Test, protected MapFixture {
 protected:
  FramesBetweenTest() {
    for (const double x : {0.0, 1.0, 2.0}) {
      const KeyFrameId id = frame(x);
      moves.push_back({id, map.at(id).frame, 1, map.at(id).T_cw, map.at(id).T_cw});
    }
  }
  void move(size_t k, const SE3& T_cw) {
    moves[k].after = T_cw;
    map.set_pose(moves[k].key_frame, T_cw);
  }
  // Where a frame is that was at x, given relative to the k-th key frame.
  SE3 carried(int64_t frame, double x, size_t k) const {
    const RelativePose pose{moves[k].key_frame, 1, pose_at(x) * moves[k].before.inverse()};
    const auto now = FramesBetween(moves, moves).carried(map, frame, pose);
    return now ? now->resolved(map)->T_cw(map) : SE3();
  }

  std::vector<KeyFrameMove> moves;
};

TEST_F(FramesBetweenTest, WhereEverythingGrewAndTurnedFramesDoToo) {
  const auto moved_place = [](double x) {  // twice as far, and turned about the origin
    const SE3 T_wc = SE3::exp((Vector6d() << 0, 0, 0, 0.1, 0.4, -0.2).finished()) * pose_at(2 * x).inverse();
    return T_wc.inverse();
  };
  for (size_t k = 0; k < 3; ++k) move(k, moved_place(static_cast<double>(k)));
  for (const auto& [at, x, k] :
       {std::tuple{3, 0.3, size_t{0}}, {3, 0.3, size_t{2}}, {15, 1.5, size_t{1}}, {10, 1.0, size_t{0}}})
    EXPECT_LT((carried(at, x, k) * moved_place(x).inverse()).log().norm(), 1e-9) << at;
}

// The last metre is two now, and turns: frames go from one key frame to the other without a jump.
TEST_F(FramesBetweenTest, FramesStayBetweenTheirKeyFrames) {
  const SE3 T_wc(so3_exp({0, 0.3, 0}), Eigen::Vector3d(3, 0, 0));
  move(2, T_wc.inverse());
  double last = 1;
  for (int k = 1; k < 50; ++k) {
    const double s = k / 50.0;
    const SE3 now = carried(10 + k / 6, 1 + s, 1).inverse();
    EXPECT_GT(now.t().x(), last);
    EXPECT_LT(now.t().x() - last, 0.12);
    EXPECT_LT(std::abs(now.t().y()), 1e-9);
    last = now.t().x();
  }
  EXPECT_GT(last, 2.9);
  EXPECT_NEAR(carried(19, 2, 1).inverse().t().x(), 3, 1e-6);
  EXPECT_NEAR(so3_log(carried(19, 2, 1).inverse().R()).y(), 0.3, 1e-6);
}

// It came back to where the first key frame is: what lies far from it tells little of its place.
TEST_F(FramesBetweenTest, AReferenceThatIsNearCountsMost) {
  move(2, pose_at(3));
  EXPECT_NEAR(carried(15, 0.01, 0).centre().x(), 0.01, 0.01);
}

TEST_F(FramesBetweenTest, BeyondTheLastKeyFrameTheReferenceCarriesThem) {
  move(2, pose_at(3));
  EXPECT_NEAR(carried(25, 2.5, 2).centre().x(), 3.5, 1e-9);
}

// Before it moved, or after.
TEST_F(FramesBetweenTest, AnErasedReferenceIsFollowed) {
  for (const KeyFrameMove& of : moves) map.attach_to_tree(of.key_frame);
  const RelativePose pose{moves[1].key_frame, 1, pose_at(0.5)};
  ASSERT_TRUE(map.erase_key_frame(moves[1].key_frame));
  for (const bool before : {true, false}) {
    std::vector<KeyFrameMove> known = moves;
    if (before) known.erase(known.begin() + 1);
    for (KeyFrameMove& of : known) of.after = pose_at(2 * of.before.centre().x());
    for (const KeyFrameMove& of : known) map.set_pose(of.key_frame, of.after);
    const auto now = FramesBetween(known, known).carried(map, 15, pose);
    ASSERT_TRUE(now);
    EXPECT_EQ(now->key_frame == moves[1].key_frame, !before);
    const KeyFrameMove& by = *std::ranges::find(known, now->key_frame, &KeyFrameMove::key_frame);
    EXPECT_NEAR((now->T_cr * by.after).centre().x(), 3, 1e-9);
  }
}

// A loop that was closed since grew the lengths around the reference.
TEST_F(FramesBetweenTest, LaterChangesOfScaleStayWithTheReader) {
  for (size_t k = 0; k < 3; ++k) move(k, pose_at(2 * static_cast<double>(k)));
  const RelativePose pose{moves[1].key_frame, 1, pose_at(0.5)};
  map.correct_pose(moves[1].key_frame, pose_at(9), 4);
  const auto now = FramesBetween(moves, moves).carried(map, 15, pose);
  ASSERT_TRUE(now);
  EXPECT_EQ(now->scale, 1);
  EXPECT_NEAR(now->resolved(map)->T_cw(map).centre().x(), 9 + 4 * 1, 1e-9);
}

TEST_F(FramesBetweenTest, WithoutAReferenceThatMovedThereIsNothing) {
  const KeyFrameId other = map.begin_submap(99, 0, pose_at(0), features(400, false));
  EXPECT_FALSE(FramesBetween(moves, moves).carried(map, 5, RelativePose::at(map, other)));
  EXPECT_FALSE(FramesBetween({}, {}).carried(map, 5, RelativePose::at(map, moves[0].key_frame)));
}

}  // namespace
}  // namespace covis
