// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "synth/things/test_things.h"
#include "synth/worlds/world.h"

namespace covis::synth {
namespace {

TEST(WorldDesk, ThePathLeadsThroughASoundScene) {
  const World world = make_desk(5);
  expect_sound(world.scene);
  const auto box = extent(world.scene);
  const double seconds = world.frames / world.fps;
  for (double t = 0; t < seconds; t += seconds / 200) {
    const Vector3d at = world.path.at(t).position;
    EXPECT_TRUE(box.contains(at)) << at.transpose();
    EXPECT_GT(at.z(), 0.2);
  }
}

}  // namespace
}  // namespace covis::synth
