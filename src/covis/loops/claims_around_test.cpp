// SPDX-License-Identifier: Apache-2.0
#include "covis/loops/claims_around.h"

#include <gtest/gtest.h>

#include "covis/map/test_point_scene.h"

namespace covis {
namespace {

// Two walks along a wall, too short for the first key frame to see what the last one does.
struct ClaimsAroundTest : testing::Test {
  void SetUp() override {
    world.add_key_frames(kWalk, 0, 10);
    world.begin_submap();
    world.add_key_frames(kWalk, 0, 10);
  }
  KeyFrameId first(size_t k) const { return world.frames[k]; }
  KeyFrameId second(size_t k) const { return world.frames[kWalk + k]; }

  static constexpr size_t kWalk = 8;
  const PointScene scene = PointScene::wall(2400, 100);
  SceneMap world{scene};
  ClaimsAround around;
};

TEST_F(ClaimsAroundTest, ThoseOfNeighboursAreOfTheSamePlace) {
  const auto map = world.shared.read();
  ASSERT_GE(map->weight(first(0), first(1)), kCovisibilityThreshold);
  ASSERT_LT(map->weight(first(0), first(7)), kCovisibilityThreshold);
  for (int k = 0; k < kClaimsOfAPlace; ++k) {
    EXPECT_FALSE(around.suffice(*map, first(0), second(0))) << k;
    around.add(*map, first(k % 2), second(1 - k % 2));
  }
  EXPECT_TRUE(around.suffice(*map, first(0), second(0)));
  EXPECT_TRUE(around.suffice(*map, second(1), first(1))) << "whichever of them asks";
  EXPECT_FALSE(around.suffice(*map, first(7), second(7)));
  EXPECT_FALSE(around.suffice(*map, first(0), second(7))) << "another place";
}

TEST_F(ClaimsAroundTest, FewerAreMadeOfEachPlaceWhereThereAreMany) {
  const auto map = world.shared.read();
  for (int k = 0; k < kTiesOfAPlace; ++k) around.add(*map, first(0), second(0));
  for (int k = kTiesOfAPlace; k < kManyClaims; ++k) {
    EXPECT_FALSE(around.suffice(*map, first(0), second(0))) << k;
    around.add(*map, first(7), second(7));
  }
  EXPECT_TRUE(around.suffice(*map, first(0), second(0)));
}

}  // namespace
}  // namespace covis
