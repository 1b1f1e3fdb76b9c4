// SPDX-License-Identifier: Apache-2.0
#include "covis/matching/point_fuser.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "covis/map/map_state.h"
#include "covis/map/test_point_scene.h"

namespace covis {
namespace {

// Two key frames of one place that share no point.
struct PointFuserTest : testing::Test {
  void SetUp() override {
    world.add_key_frames(1);
    world.forget_points();
    world.add_key_frames(1, 1);
    points = points_of(*world.shared.read(), {&world.frames[0], 1});
  }
  int fuse(const FuseOptions& options) {
    const int fused = fuser.fuse(world.shared, world.frames[1], points, options);
    EXPECT_EQ(world.shared.read()->check(), "");
    return fused;
  }

  const PointScene scene = PointScene::wall();
  SceneMap world{scene};
  std::vector<MapPointId> points;
  PointFuser fuser;
};

TEST_F(PointFuserTest, PointsOfOnePlaceBecomeOne) {
  const size_t before = world.shared.read()->point_count();
  const int fused = fuse({});
  EXPECT_GT(fused, 100);
  const auto map = world.shared.read();
  EXPECT_EQ(map->point_count(), before - static_cast<size_t>(fused));
  EXPECT_EQ(map->weight(world.frames[0], world.frames[1]), fused);
}

TEST_F(PointFuserTest, TheGivenPointStaysWhenAsked) {
  fuse({.keep = FuseKeep::given});
  const auto map = world.shared.read();
  size_t alive = 0;
  for (const MapPointId& id : points) alive += map->find(id) != nullptr;
  EXPECT_EQ(alive, points.size());
}

TEST_F(PointFuserTest, TheMoreObservedPointStaysOtherwise) {
  // A third key frame sees those of the second.
  world.add_key_frames(1, 2);
  const size_t before = points.size();
  fuse({});
  const auto map = world.shared.read();
  size_t alive = 0;
  for (const MapPointId& id : points) alive += map->find(id) != nullptr;
  EXPECT_LT(alive, before / 2);
}

TEST_F(PointFuserTest, AFeatureWithoutAPointGetsTheObservation) {
  {
    const auto map = world.shared.write();
    for (const MapPointId& id : points_of(*map, {&world.frames[1], 1})) map->erase_point(id);
  }
  const int fused = fuse({});
  EXPECT_GT(fused, 100);
  EXPECT_EQ(fuse({}), 0) << "they are observed now";
}

// The more similar of two points that are one gets the keypoint. The other may be found once that one is fused.
TEST_F(PointFuserTest, APointWhoseKeypointWasGivenAwayIsNoVainSearch) {
  world.forget_points();
  world.add_key_frames(1, 1);
  const std::vector<MapPointId> again = points_of(*world.shared.read(), {&world.frames[2], 1});
  points.insert(points.end(), again.begin(), again.end());
  FuseMemory memory;
  const int fused = fuser.fuse(world.shared, world.frames[1], points, {}, &memory);
  EXPECT_GT(fused, 100);
  const auto vain = std::count_if(again.begin(), again.end(), [&](auto id) { return memory.has(world.frames[1], id); });
  EXPECT_LT(vain, fused / 2);
}

TEST_F(PointFuserTest, AMemoryOfVainSearchesChangesNothing) {
  world.forget_points();
  world.add_key_frames(1, 2);
  const std::vector<KeyFrameId>& frames = world.frames;
  const MapState state = world.shared.read()->state();
  const auto fuse_all = [&](SharedMap& shared, FuseMemory* memory) {
    int fused = 0;
    for (int round = 0; round < 3; ++round) {
      const std::vector<MapPointId> all = points_of(*shared.read(), frames);
      for (const KeyFrameId& target : frames) fused += fuser.fuse(shared, target, all, {}, memory);
    }
    return fused;
  };
  SharedMap with, without;
  *with.write() = std::move(*Map::from_state(MapState(state)));
  *without.write() = std::move(*Map::from_state(MapState(state)));
  FuseMemory memory;
  EXPECT_EQ(fuse_all(with, &memory), fuse_all(without, nullptr));
  const auto after = [](const SharedMap& shared) {
    const auto map = shared.read();
    std::vector<MapPointId> seen;
    for (const KeyFrameId& id : map->key_frames())
      seen.insert(seen.end(), map->at(id).points.begin(), map->at(id).points.end());
    return seen;
  };
  EXPECT_EQ(after(with), after(without));
  size_t vain = 0;
  for (const MapPointId& id : points) vain += memory.has(frames[1], id) || memory.has(frames[2], id);
  EXPECT_GT(vain, 0u);
}

TEST_F(PointFuserTest, AStaleTargetIsLeft) { EXPECT_EQ(fuser.fuse(world.shared, KeyFrameId{77, 0}, points, {}), 0); }

}  // namespace
}  // namespace covis
