// SPDX-License-Identifier: Apache-2.0
#include "covis/loops/loop_matches.h"

#include <gtest/gtest.h>

#include "covis/loops/test_loop_scene.h"

namespace covis {
namespace {

class LoopMatchesTest : public testing::Test {
 protected:
  void SetUp() override { around.go_around(); }
  LoopCandidate candidate() const { return {*around.world.shared.read(), around.current, around.place()}; }

  LoopScene around;
};

TEST_F(LoopMatchesTest, MatchesByDescriptorAgreeWithTheTruth) {
  const LoopCandidate both = candidate();
  const std::vector<Sim3Match> matches = match_by_descriptor(both);
  ASSERT_GT(matches.size(), 40u);
  for (const Sim3Match& m : matches) {
    // Each map by itself is right but for the drift of a few key frames.
    EXPECT_LT((m.z_1 - both.camera.project(m.p_1)).norm(), 20);
    EXPECT_LT((m.z_2 - both.camera.project(m.p_2)).norm(), 20);
  }
}

TEST_F(LoopMatchesTest, WithoutMembersThereAreNone) {
  LoopCandidate none = candidate();
  none.members.clear();
  EXPECT_TRUE(match_by_descriptor(none).empty());
}

TEST_F(LoopMatchesTest, EachPairCountsOnceThoughBothSidesFindIt) {
  const LoopCandidate both = candidate();
  const KeyFrameView &current = both.current, &place = both.members.front();
  // The same points of the scene, by both key frames' features.
  const auto& views = around.world.views;
  const PointScene::View &now = views.back(), &then = views[(views.size() - 1) % LoopScene::kSteps];
  std::vector<PointMatch> here, there;
  size_t pairs = 0;
  for (uint32_t f = 0; f < now.point.size(); ++f) {
    for (uint32_t g = 0; g < then.point.size(); ++g) {
      if (now.point[f] != then.point[g] || !current.points[f].valid() || !place.points[g].valid()) continue;
      ++pairs;
      here.push_back({f, static_cast<uint32_t>(index_of(both.place.points, place.points[g]))});
      there.push_back({g, static_cast<uint32_t>(index_of(both.here.points, current.points[f]))});
    }
  }
  ASSERT_GT(pairs, 100u);
  EXPECT_EQ(match_both_ways(both, here, {}).size(), pairs);
  EXPECT_EQ(match_both_ways(both, {}, there).size(), pairs);
  EXPECT_EQ(match_both_ways(both, here, there).size(), pairs);
}

TEST_F(LoopMatchesTest, APointThatBothHaveTellsNothing) {
  LoopCandidate both = candidate();
  const MapPointId shared = both.members.front().points.front();
  ASSERT_TRUE(shared.valid());
  both.current.points.front() = shared;
  const PointMatch match{0, static_cast<uint32_t>(index_of(both.place.points, shared))};
  EXPECT_TRUE(match_both_ways(both, {match}, {}).empty());
}

}  // namespace
}  // namespace covis
