// SPDX-License-Identifier: Apache-2.0
#include "covis/map/map_memory.h"

#include <gtest/gtest.h>

#include "covis/map/test_point_scene.h"

namespace covis {
namespace {

TEST(MapMemory, CountsWhatTheMapHolds) {
  EXPECT_EQ(memory_of(Map()), 0u);
  const PointScene scene = PointScene::wall();
  SceneMap world(scene);
  world.add_key_frames(1);
  const size_t one = memory_of(*world.shared.read());
  const Features& features = *world.shared.read()->at(world.frames[0]).features;
  const auto size = static_cast<size_t>(features.size());
  EXPECT_GT(one, size * (sizeof(Descriptor) + 5 * sizeof(float) + sizeof(MapPointId)));
  world.add_key_frames(9, 1);
  const size_t ten = memory_of(*world.shared.read());
  EXPECT_GT(ten, 5 * one);
  world.shared.write()->erase_key_frame(world.frames[9]);
  EXPECT_LT(memory_of(*world.shared.read()), ten);
}

TEST(MapMemory, IsTheSameForTheSameMap) {
  const PointScene scene = PointScene::wall();
  SceneMap one(scene), other(scene);
  one.add_key_frames(8);
  other.add_key_frames(8);
  EXPECT_EQ(memory_of(*one.shared.read()), memory_of(*other.shared.read()));
}

// Tracking brings them while mapping asks how large the map is, which may not depend on when they come.
TEST(MapMemory, DoesNotCountColours) {
  const PointScene scene = PointScene::wall();
  SceneMap world(scene);
  world.add_key_frames(1);
  const size_t before = memory_of(*world.shared.read());
  const auto size = static_cast<size_t>(world.shared.read()->at(world.frames[0]).features->size());
  ASSERT_TRUE(world.shared.write()->set_colours(world.frames[0], std::make_shared<const std::vector<Colour>>(size)));
  EXPECT_EQ(memory_of(*world.shared.read()), before);
}

}  // namespace
}  // namespace covis
