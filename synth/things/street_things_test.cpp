// SPDX-License-Identifier: Apache-2.0
#include "synth/things/street_things.h"

#include <gtest/gtest.h>

#include "synth/things/materials.h"
#include "synth/things/test_things.h"

namespace covis::synth {
namespace {

TEST(StreetThings, ABuildingStandsBehindItsFront) {
  Scene scene(2);
  add_building(scene, {{0, 0, 0}, 0}, 12, 10);
  expect_sound(scene);
  const auto box = extent(scene);
  EXPECT_NEAR(box.sizes().y(), 12, 1.5);
  EXPECT_LT(box.min().x(), -8);
  EXPECT_LT(box.max().x(), 2.5) << "little but signs and steps before the front";
  EXPECT_GT(box.max().z(), 4);
}

TEST(StreetThings, ACarHasTheSizeOfOne) {
  for (const uint64_t seed : {1u, 2u, 3u}) {
    Scene scene(seed);
    add_car(scene, {{0, 0, 0}, 0});
    expect_sound(scene);
    const auto box = extent(scene);
    EXPECT_GT(box.sizes().x(), 3);
    EXPECT_LT(box.sizes().x(), 6.5);
    EXPECT_GT(box.sizes().y(), 1.4);
    EXPECT_LT(box.sizes().y(), 2.6);
    EXPECT_GT(box.sizes().z(), 1.1);
    EXPECT_LT(box.sizes().z(), 3);
  }
}

TEST(StreetThings, ATreeHasItsCrownAboveItsTrunk) {
  Scene scene(1);
  const int leaf = scene.add_texture(leaves(scene.random, 0.5, 0.5, 100));
  add_tree(scene, {{3, 4, 0}, 0}, leaf);
  int crown = 0;
  for (const Polygon& p : scene.polygons) {
    if (p.texture != leaf) continue;
    ++crown;
    EXPECT_GT(p.centre.z(), 1);
  }
  EXPECT_GT(crown, 50);
  EXPECT_LT((extent(scene).center().head<2>() - Vector2d(3, 4)).norm(), 1);
}

}  // namespace
}  // namespace covis::synth
