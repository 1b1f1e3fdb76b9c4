// SPDX-License-Identifier: Apache-2.0
#include "synth/things/interior.h"

#include <gtest/gtest.h>

#include <vector>

#include "synth/things/test_things.h"

namespace covis::synth {
namespace {

const Wall kWall{{0, 0}, {0, 5}, 2.6};  // its foot along y; who stands before it looks along -x

TEST(Interior, APlaceAtAWallFacesAwayFromIt) {
  const Wall wall{{0, 5}, {0, 0}, 2.6};
  const Place at = wall.at(1);
  EXPECT_LT((at.origin - Vector3d(0, 4, 0)).norm(), 1e-12);
  EXPECT_DOUBLE_EQ(wall.length(), 5);
  const Vector3d right = at(0, 1, 0) - at.origin;
  EXPECT_LT((right - Vector3d(0, -1, 0)).norm(), 1e-9) << "local y is towards the wall's right end";
}

TEST(Interior, FurnitureStaysAlongItsWall) {
  Scene scene(4);
  std::vector<Floor> floors;
  floors.push_back({{-5, -5}, floor_canvas(scene.random, 10, 10)});
  furnish(scene, kWall, floors, {Kind::bookcase, Kind::sofa, Kind::cabinet, Kind::boxes}, 0.5, 0.4);
  expect_sound(scene);
  const auto box = extent(scene);
  EXPECT_GT(box.min().y(), 0.3);
  EXPECT_LT(box.max().y(), 4.8);
  EXPECT_LE(box.max().z(), 2.6);
  EXPECT_GT(box.sizes().y(), 2) << "it fills the wall";
}

TEST(Interior, AShadowDarkensTheFloorBelowTheThing) {
  Random random(1);
  std::vector<Floor> floors{{{0, 0}, Canvas(4, 4, 20, 150)}};
  const double before = sum_of(floors[0].canvas);
  add_shadow(floors, {{2, 2, 0}, 0}, 0.5, 1);
  EXPECT_LT(sum_of(floors[0].canvas), before);
  const double once = sum_of(floors[0].canvas);
  add_shadow(floors, {{40, 2, 0}, 0}, 0.5, 1);
  EXPECT_EQ(sum_of(floors[0].canvas), once) << "beside the floor there is none to darken";
}

}  // namespace
}  // namespace covis::synth
