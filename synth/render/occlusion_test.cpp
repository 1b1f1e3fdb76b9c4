// SPDX-License-Identifier: Apache-2.0
#include "synth/render/occlusion.h"

#include <gtest/gtest.h>

namespace covis::synth {
namespace {

// Walls of 1 m x 1 m across the x axis, at 1, 2, … metres, seen from the origin; every third faces away.
Scene row_of_walls(int count) {
  Scene scene(1);
  const Skin skin{.texture = scene.add_texture(Canvas(1, 1, 20, 100))};
  for (int i = 1; i <= count; ++i) {
    const double x = i;
    if (i % 3 == 0) {
      scene.add_rect({x, -0.5, 0.5}, {0, 1, 0}, {0, 0, -1}, skin);
    } else {
      scene.add_rect({x, 0.5, 0.5}, {0, -1, 0}, {0, 0, -1}, skin);
    }
  }
  return scene;
}

TEST(Occlusion, TheFirstWallOnTheWayIsHit) {
  const Scene scene = row_of_walls(40);
  const Occlusion occlusion(scene);
  for (int i = 0; i < 40; ++i) {
    const auto hit = occlusion.first({i + 0.25, 0.1, -0.2}, {2, 0, 0}, 100, -1);
    ASSERT_TRUE(hit);
    EXPECT_EQ(hit->polygon, i);
    EXPECT_NEAR(hit->distance, 0.375, 1e-12) << "in lengths of the direction";
  }
  EXPECT_FALSE(occlusion.first({40.25, 0, 0}, {1, 0, 0}, 100, -1));
  EXPECT_FALSE(occlusion.first({0, 0.6, 0}, {1, 0, 0}, 100, -1)) << "beside the walls";
  EXPECT_FALSE(occlusion.first({0.5, 0, 0}, {1, 0, 0}, 0.4, -1)) << "not that far";
  EXPECT_EQ(occlusion.first({0.5, 0, 0}, {1, 0, 0}, 100, 0)->polygon, 1) << "its own wall does not count";
}

TEST(Occlusion, WallsStandBetweenPointsOnTheirTwoSides) {
  const Scene scene = row_of_walls(3);
  const Occlusion occlusion(scene);
  EXPECT_TRUE(occlusion.blocked({0.5, 0, 0}, {1.5, 0, 0}, -1));
  EXPECT_TRUE(occlusion.blocked({1.5, 0, 0}, {0.5, 0, 0}, -1)) << "also from behind";
  EXPECT_FALSE(occlusion.blocked({0.5, 0, 0}, {1.5, 0, 0}, 0));
  EXPECT_FALSE(occlusion.blocked({1.2, 0, 0}, {1.8, 0, 0}, -1));
  EXPECT_FALSE(occlusion.blocked({0.5, 0.7, 0}, {3.5, 0.7, 0}, -1));
}

TEST(Occlusion, TheSkyStopsNoLight) {
  Scene scene = row_of_walls(2);
  scene.polygons[0].sky = true;
  const Occlusion occlusion(scene);
  EXPECT_EQ(occlusion.first({0, 0, 0}, {1, 0, 0}, 100, -1)->polygon, 1);
  EXPECT_FALSE(Occlusion(Scene(1)).blocked({0, 0, 0}, {1, 0, 0}, -1)) << "there is nothing";
}

}  // namespace
}  // namespace covis::synth
