// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "synth/things/test_things.h"
#include "synth/worlds/world.h"

namespace covis::synth {
namespace {

TEST(WorldStreet, ThePathLeadsThroughASoundScene) {
  const World world = make_street(5);
  expect_sound(world.scene);
  const auto box = extent(world.scene);
  const double seconds = world.frames / world.fps;
  for (double t = 0; t < seconds; t += seconds / 200) {
    const Vector3d at = world.path.at(t).position;
    EXPECT_TRUE(box.contains(at)) << at.transpose();
    EXPECT_GT(at.z(), 0.2);
  }
}

TEST(WorldStreet, AFarWayIsAsLongAsAskedFor) {
  const auto length = [](const World& world) {
    double metres = 0;
    const double period = world.path.period();
    for (int i = 0; i < 2000; ++i)
      metres += (world.path.at((i + 1) * period / 2000).position - world.path.at(i * period / 2000).position).norm();
    return metres;
  };
  EXPECT_NEAR(length(make_street(1)), 310, 40);
  EXPECT_NEAR(length(make_street(1, 600)), 600, 60);
}

}  // namespace
}  // namespace covis::synth
