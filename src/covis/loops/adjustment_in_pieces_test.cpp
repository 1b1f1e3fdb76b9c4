// SPDX-License-Identifier: Apache-2.0
#include "covis/loops/adjustment_in_pieces.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "covis/core/random.h"
#include "covis/map/test_point_scene.h"

namespace covis {
namespace {

constexpr size_t kFrames = 40;

struct AdjustmentInPieces : testing::Test {
  void SetUp() override { world.add_key_frames(kFrames); }
  // Each but the root off its place.
  void disturb() {
    Random random(2);
    const auto map = world.shared.write();
    for (size_t k = 1; k < kFrames; ++k) {
      Vector6d xi;
      for (int i = 0; i < 6; ++i) xi(i) = random.uniform(-0.002, 0.002);
      map->set_pose(world.frames[k], SE3::exp(xi) * scene.T_cw(k));
    }
  }
  // The greatest error of the motion from a key frame to the next.
  double worst() const {
    const auto map = world.shared.read();
    const auto off = [&](size_t k) { return map->at(world.frames[k]).T_cw * scene.T_wc_of(k); };
    double greatest = 0;
    for (size_t k = 1; k < kFrames; ++k) greatest = std::max(greatest, (off(k) * off(k - 1).inverse()).log().norm());
    return greatest;
  }
  std::vector<std::vector<KeyFrameId>> pieces(bool backwards = false) const {
    return pieces_of(*world.shared.read(), 0, 12, backwards);
  }

  const PointScene scene = PointScene::wall(1600, kFrames);
  SceneMap world{scene};
};

TEST_F(AdjustmentInPieces, EachKeyFrameIsInOnePieceWithItsNeighbours) {
  std::vector<KeyFrameId> all;
  for (const auto& piece : pieces()) {
    EXPECT_LE(piece.size(), 12u);
    const auto map = world.shared.read();
    for (size_t k = 1; k < piece.size(); ++k) {
      const auto shares = [&](KeyFrameId other) { return map->weight(piece[k], other) > 0; };
      EXPECT_TRUE(std::any_of(piece.begin(), piece.begin() + static_cast<ptrdiff_t>(k), shares));
    }
    all.insert(all.end(), piece.begin(), piece.end());
  }
  std::sort(all.begin(), all.end());
  EXPECT_EQ(all, world.shared.read()->key_frames(0));
  EXPECT_EQ(pieces()[0][0], world.frames.front());
  EXPECT_EQ(pieces(true)[0][0], world.frames.back()) << "so that borders of one sweep are amid pieces of the next";
}

TEST_F(AdjustmentInPieces, MakesKeyFramesAgreeWithTheirNeighbours) {
  disturb();
  const double before = worst();
  const SE3 root = world.shared.read()->at(world.frames[0]).T_cw;
  const auto first = adjust_in_pieces(world.shared, pieces(), 10);
  ASSERT_TRUE(first);
  const auto second = adjust_in_pieces(world.shared, pieces(true), 10);
  ASSERT_TRUE(second);
  EXPECT_LT(second->after, 0.01 * first->before);
  EXPECT_LT(worst(), 0.5 * before);
  const auto map = world.shared.read();
  EXPECT_EQ(map->check(), "");
  EXPECT_EQ(map->at(world.frames[0]).T_cw.t(), root.t()) << "the root is the world";
}

TEST_F(AdjustmentInPieces, NothingIsAdjustedWithoutPieces) {
  EXPECT_FALSE(adjust_in_pieces(world.shared, {}, 10));
  EXPECT_TRUE(pieces_of(*world.shared.read(), 7, 12, false).empty()) << "no such submap";
}

}  // namespace
}  // namespace covis
