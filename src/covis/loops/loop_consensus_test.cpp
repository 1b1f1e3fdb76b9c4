// SPDX-License-Identifier: Apache-2.0
#include "covis/loops/loop_consensus.h"

#include <gtest/gtest.h>

#include "covis/loops/test_loop_scene.h"

namespace covis {
namespace {

// Twice around: each key frame of the second round sees a place of the first, and has a claim on where it is.
class LoopConsensusTest : public testing::Test {
 protected:
  void SetUp() override { around.go_around(24); }

  // The claim of a key frame of the second round, beside the truth by `off`, in its camera.
  Loop claim_in(const Map& map, size_t k, const Sim3& off = Sim3()) const {
    const KeyFrameId place = around.world.frames[k % LoopScene::kSteps];
    Loop loop{LoopPlace(map, place), LoopRelation::same_submap, off * Sim3(around.scene.T_cw(k)), {}};
    uint32_t feature = 0;
    for (const MapPointId& point : map.at(place).points) {
      if (point.valid()) loop.matches.emplace_back(feature++, point);
    }
    return loop;
  }
  Loop claim(size_t k, const Sim3& off = Sim3()) const { return claim_in(*around.world.shared.read(), k, off); }
  bool confirms(LoopConsensus& consensus, size_t k, const Sim3& off = Sim3(),
                LoopConsensus::By by = LoopConsensus::By::other_points) const {
    return consensus.confirms(*around.world.shared.read(), around.world.frames[k], claim(k, off), by);
  }

  static constexpr size_t kFirst = LoopScene::kSteps + 2, kNear = kFirst + 1, kFar = kFirst + 12;
  LoopScene around;
};

TEST_F(LoopConsensusTest, ASecondPlaceConfirms) {
  LoopConsensus consensus;
  EXPECT_FALSE(confirms(consensus, kFirst)) << "one alone";
  EXPECT_TRUE(confirms(consensus, kFar));
}

TEST_F(LoopConsensusTest, TheSamePointsSeenAgainDoNot) {
  LoopConsensus consensus;
  EXPECT_FALSE(confirms(consensus, kFirst));
  EXPECT_FALSE(confirms(consensus, kNear));
  EXPECT_TRUE(confirms(consensus, kNear, Sim3(), LoopConsensus::By::any_points)) << "unless that is asked for";
}

TEST_F(LoopConsensusTest, AKeyFrameDoesNotConfirmItself) {
  for (const LoopConsensus::By by : {LoopConsensus::By::other_points, LoopConsensus::By::any_points}) {
    LoopConsensus consensus;
    const KeyFrameId current = around.world.frames[kFirst];
    const auto map = around.world.shared.read();
    Loop elsewhere = claim(kFar);
    elsewhere.S_cw = claim(kFirst).S_cw;
    EXPECT_FALSE(consensus.confirms(*map, current, claim(kFirst), by));
    EXPECT_FALSE(consensus.confirms(*map, current, elsewhere, by));
  }
}

// What wants any second opinion has passed fewer tests than what wants one by other points.
TEST_F(LoopConsensusTest, AWeakerClaimDoesNotConfirmAStronger) {
  LoopConsensus consensus;
  EXPECT_FALSE(confirms(consensus, kFirst, Sim3(), LoopConsensus::By::any_points));
  EXPECT_FALSE(confirms(consensus, kFar));
  EXPECT_TRUE(confirms(consensus, kFar + 1, Sim3(), LoopConsensus::By::any_points));
}

TEST_F(LoopConsensusTest, AnotherOpinionDoesNot) {
  const Sim3 turned(so3_exp({0, 0.2, 0}), Eigen::Vector3d::Zero(), 1);
  const Sim3 moved(Eigen::Matrix3d::Identity(), Eigen::Vector3d(3, 0, 0), 1);
  const Sim3 grown(Eigen::Matrix3d::Identity(), Eigen::Vector3d::Zero(), 1.5);
  for (const Sim3& off : {turned, moved, grown}) {
    LoopConsensus consensus;
    EXPECT_FALSE(confirms(consensus, kFirst));
    EXPECT_FALSE(confirms(consensus, kFar, off));
  }
}

// Background adjustments move the map, which a young one has often.
TEST_F(LoopConsensusTest, AClaimByAnyPointsIsGoodForTheMapAsItIsNow) {
  const SE3 moved(so3_exp({0, 0.2, 0}), {3, 0, 0});
  for (const bool all : {true, false}) {
    LoopConsensus consensus;
    EXPECT_FALSE(confirms(consensus, kFirst, Sim3(), LoopConsensus::By::any_points));
    const auto map = around.world.shared.write();
    for (size_t k = 0; k < around.world.frames.size(); ++k) {
      if (all || k == kFirst) map->set_pose(around.world.frames[k], map->at(around.world.frames[k]).T_cw * moved);
    }
    map->count_move();
    Loop now = claim_in(*map, kNear);
    if (all) now.S_cw = now.S_cw * Sim3(moved);
    EXPECT_EQ(consensus.confirms(*map, around.world.frames[kNear], now, LoopConsensus::By::any_points), all);
    if (!all) continue;
    for (const KeyFrameId& id : around.world.frames) map->set_pose(id, map->at(id).T_cw * moved.inverse());
  }
}

TEST_F(LoopConsensusTest, AClaimByOtherPointsIsGoodUntilTheMapMoves) {
  LoopConsensus consensus;
  EXPECT_FALSE(confirms(consensus, kFirst));
  around.world.shared.write()->count_move();
  EXPECT_FALSE(confirms(consensus, kFar));
}

TEST_F(LoopConsensusTest, AClaimInAnotherUnitIsNone) {
  LoopConsensus consensus;
  EXPECT_FALSE(confirms(consensus, kFirst, Sim3(), LoopConsensus::By::any_points));
  {
    const auto map = around.world.shared.write();
    map->correct_pose(around.world.frames[kFirst], map->at(around.world.frames[kFirst]).T_cw, 2);
  }
  EXPECT_FALSE(confirms(consensus, kNear, Sim3(), LoopConsensus::By::any_points));
}

TEST_F(LoopConsensusTest, AnySecondOpinionHasToComeSoon) {
  LoopConsensus consensus;
  EXPECT_FALSE(confirms(consensus, kFirst, Sim3(), LoopConsensus::By::any_points));
  EXPECT_FALSE(confirms(consensus, kFar, Sim3(), LoopConsensus::By::any_points));
}

TEST_F(LoopConsensusTest, ResetForgets) {
  LoopConsensus consensus;
  EXPECT_FALSE(confirms(consensus, kFirst));
  consensus.reset();
  EXPECT_FALSE(confirms(consensus, kFar));
}

TEST_F(LoopConsensusTest, AClaimWithoutPointsIsNone) {
  LoopConsensus consensus;
  Loop empty = claim(kFirst);
  empty.matches.clear();
  EXPECT_FALSE(consensus.confirms(*around.world.shared.read(), around.world.frames[kFirst], empty,
                                  LoopConsensus::By::any_points));
}

}  // namespace
}  // namespace covis
