// SPDX-License-Identifier: Apache-2.0
#include "covis/mapping/map_limit.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "covis/map/map_memory.h"
#include "covis/map/test_point_scene.h"

namespace covis {
namespace {

size_t memory_in(const SharedMap& map) { return memory_of(*map.read()); }

// Adds key frames one after the other along a ring and keeps the map within `most`; returns how many were erased.
int grow(SceneMap& world, size_t count, size_t most) {
  int erased = 0;
  for (size_t k = 0; k < count; ++k) {
    world.add_key_frames(1, k);
    erased += limit_map(world.shared, world.frames.back(), most).erased;
  }
  return erased;
}

TEST(MapLimit, AMapWithinItsBoundStaysAsItIs) {
  const PointScene scene = PointScene::ring(1200, 120);
  SceneMap world(scene);
  EXPECT_EQ(grow(world, 120, size_t{1} << 40), 0);
  EXPECT_EQ(world.shared.read()->key_frame_count(), 120u);
}

TEST(MapLimit, AGrowingMapStaysWithinItsBound) {
  const PointScene scene = PointScene::ring(1200, 400);
  SceneMap all(scene), bounded(scene);
  grow(all, 400, size_t{1} << 40);
  const size_t most = memory_in(all.shared) / 2;
  EXPECT_GT(grow(bounded, 400, most), 100);
  EXPECT_LT(memory_in(bounded.shared), most * 21 / 20) << "some key frames more until it is looked at again";
  EXPECT_GT(memory_in(bounded.shared), most * 4 / 5);
  const auto map = bounded.shared.read();
  EXPECT_EQ(map->check(), "");
  EXPECT_TRUE(map->find(bounded.frames[0])) << "the root";
  for (size_t k = 350; k < 400; ++k) EXPECT_TRUE(map->find(bounded.frames[k])) << "the newest: " << k;
}

TEST(MapLimit, WhereTheMapIsDenseItGivesUpMore) {
  const PointScene scene = PointScene::ring(1200, 400);
  SceneMap world(scene);
  world.add_key_frames(50, 0, 4);     // the first half of the ring, every fourth view
  world.add_key_frames(100, 200, 1);  // a quarter, every view
  world.add_key_frames(60, 300, 1);   // the newest
  int erased = 0;
  for (size_t k = 0; k < 40; ++k) {  // it is looked at again and again
    world.add_key_frames(1, 360 + k);
    erased += limit_map(world.shared, world.frames.back(), memory_in(world.shared) - 1).erased;
  }
  ASSERT_GT(erased, 10);
  const auto map = world.shared.read();
  const auto gone = [&](size_t first, size_t count) {
    size_t n = 0;
    for (size_t k = first; k < first + count; ++k) n += map->find(world.frames[k]) == nullptr;
    return n;
  };
  EXPECT_LT(gone(0, 50) * 4, gone(50, 100));
}

TEST(MapLimit, ABoundThatIsTooSmallLeavesWhatIsNeeded) {
  const PointScene scene = PointScene::ring(1200, 200);
  SceneMap world(scene);
  grow(world, 200, 1);
  LimitReport last;
  for (size_t k = 0; k < 8; ++k) {  // it is looked at once in so many key frames
    world.add_key_frames(1, 199);
    const LimitReport report = limit_map(world.shared, world.frames.back(), 1);
    last.erased += report.erased;
    last.is_out_of_reach |= report.is_out_of_reach;
  }
  EXPECT_TRUE(last.erased > 0 || last.is_out_of_reach);
  const auto map = world.shared.read();
  EXPECT_EQ(map->check(), "");
  EXPECT_GE(map->key_frame_count(), 51u);
  EXPECT_LT(map->key_frame_count(), 110u);
}

}  // namespace
}  // namespace covis
