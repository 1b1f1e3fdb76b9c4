// SPDX-License-Identifier: Apache-2.0
#include "synth/things/table_group.h"

#include <gtest/gtest.h>

#include <vector>

#include "synth/things/test_things.h"

namespace covis::synth {
namespace {

TEST(TableGroup, TakesTwoByTwoMetres) {
  Scene scene(1);
  std::vector<Floor> floors{{{0, 0}, Canvas(6, 6, 20, 150)}};
  add_table_group(scene, {3, 2.5}, floors);
  expect_sound(scene);
  const auto box = extent(scene);
  EXPECT_LT((box.center().head<2>() - Vector2d(3, 2.5)).norm(), 0.4);
  EXPECT_LT(box.sizes().x(), 3.2);
  EXPECT_LT(box.sizes().y(), 3.2);
  EXPECT_LT(box.max().z(), 1.3);
}

}  // namespace
}  // namespace covis::synth
