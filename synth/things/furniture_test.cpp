// SPDX-License-Identifier: Apache-2.0
#include "synth/things/furniture.h"

#include <gtest/gtest.h>

#include "synth/things/materials.h"
#include "synth/things/test_things.h"

namespace covis::synth {
namespace {

// The box a thing fills, built at the origin and looking along x.
template <class Add>
Eigen::AlignedBox3d built(Add&& add, const Place& place = {}) {
  Scene scene(3);
  add(scene, place);
  expect_sound(scene);
  return extent(scene);
}

TEST(Furniture, StandsOnTheFloorBeforeItsWall) {
  const auto check = [](const Eigen::AlignedBox3d& box, double width, const char* what) {
    EXPECT_GE(box.min().z(), 0) << what;
    EXPECT_LT(box.min().z(), 0.15) << what << " stands on feet at most";
    EXPECT_GE(box.min().x(), -0.02) << what << " reaches into the wall";
    EXPECT_LE(box.sizes().y(), width + 0.12) << what;
    EXPECT_GE(box.sizes().y(), 0.6 * width) << what;
  };
  check(built([](Scene& s, const Place& p) { add_bookcase(s, p, 1.2, 1.9); }), 1.2, "bookcase");
  check(built([](Scene& s, const Place& p) { add_cabinet(s, p, 0.9, 1.1, 0.45); }), 0.9, "cabinet");
  check(built([](Scene& s, const Place& p) { add_sofa(s, p, 1.8); }), 1.8, "sofa");
  check(built([](Scene& s, const Place& p) { add_radiator(s, p, 1.0); }), 1.0, "radiator");
}

TEST(Furniture, HeightIsTheOneAskedFor) {
  EXPECT_NEAR(built([](Scene& s, const Place& p) { add_bookcase(s, p, 1, 1.9); }).max().z(), 1.9, 0.35);
  EXPECT_NEAR(built([](Scene& s, const Place& p) { add_table(s, p, 0.8, 1.4, 0.74, {}); }).max().z(), 0.74, 0.03);
}

TEST(Furniture, TurnsWithItsPlace) {
  const auto add = [](Scene& s, const Place& p) { add_sofa(s, p, 1.8); };
  const Eigen::Vector3d plain = built(add).sizes(), turned = built(add, {{5, 6, 0}, 1.5707963267948966}).sizes();
  EXPECT_NEAR(plain.x(), turned.y(), 1e-6);
  EXPECT_NEAR(plain.y(), turned.x(), 1e-6);
}

TEST(Furniture, APictureHangsOnItsWall) {
  Scene scene(1);
  const Canvas print = poster(scene.random, 0.6, 0.4, 100);
  add_picture(scene, {{0, 0, 1.5}, 0}, 0.6, 0.4, print);
  const auto box = extent(scene);
  EXPECT_NEAR(box.center().z(), 1.5, 0.02);
  EXPECT_NEAR(box.sizes().y(), 0.6, 0.1);
  EXPECT_GE(box.min().x(), -1e-9);
  EXPECT_LT(box.max().x(), 0.06);
}

}  // namespace
}  // namespace covis::synth
