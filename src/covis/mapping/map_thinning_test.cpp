// SPDX-License-Identifier: Apache-2.0
#include "covis/mapping/map_thinning.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>

#include "covis/map/test_point_scene.h"
#include "covis/matching/point_set.h"

namespace covis {
namespace {

TEST(MapThinning, KeepsSoManyKeyFramesAndThePointsTheySee) {
  const PointScene scene = PointScene::wall();
  SceneMap world(scene);
  world.add_key_frames(20);
  const auto map = world.shared.write();
  const size_t points = map->point_count();
  const std::vector<ThinnedKeyFrame> erased = thin_map(*map, 6);
  EXPECT_EQ(map->check(), "");
  EXPECT_EQ(map->key_frame_count(), 6u);
  EXPECT_EQ(erased.size(), 14u);
  EXPECT_GT(map->point_count(), points * 9 / 10);
  EXPECT_TRUE(map->find(world.frames[0])) << "the root";
}

// Ten key frames are at one place, and five along the way: those at one place go first.
TEST(MapThinning, WhatOthersSeeAnywayGoesFirst) {
  const PointScene scene = PointScene::wall();
  SceneMap world(scene);
  world.add_key_frames(10, 0, 0);
  world.add_key_frames(5, 3, 3);
  const auto map = world.shared.write();
  for (const ThinnedKeyFrame& gone : thin_map(*map, 8)) EXPECT_LT(gone.frame, 10);
  EXPECT_EQ(map->check(), "");
}

TEST(MapThinning, ABudgetThatIsKeptChangesNothing) {
  const PointScene scene = PointScene::wall();
  SceneMap world(scene);
  world.add_key_frames(4);
  EXPECT_TRUE(thin_map(*world.shared.write(), 4).empty());
  EXPECT_EQ(thin_map(*world.shared.write(), 0).size(), 3u) << "the root stays";
  EXPECT_EQ(world.shared.read()->check(), "");
}

TEST(MapThinning, ExpendableKeyFramesAreThoseThatMayGoAndLoopsLast) {
  const PointScene scene = PointScene::ring(1200, 120);
  SceneMap world(scene);
  world.add_key_frames(100);
  world.shared.write()->add_loop_edge(world.frames[50], world.frames[90]);
  const auto map = world.shared.read();
  const auto any = [](KeyFrameId) { return true; };
  EXPECT_TRUE(expendable_key_frames(*map, 0, any).empty());
  const std::vector<KeyFrameId> chosen = expendable_key_frames(*map, 200, any);
  ASSERT_EQ(chosen.size(), 99u) << "all but the root";
  for (size_t k = 0; k < chosen.size(); ++k) EXPECT_EQ(map->at(chosen[k]).loop_edges.empty(), k < 97);
  const auto first_half = [&](KeyFrameId id) { return map->at(id).serial < 50; };
  for (const KeyFrameId& id : expendable_key_frames(*map, 8, first_half)) EXPECT_LT(map->at(id).serial, 50u);
}

// A plan is the same as choosing one by one, as long as none becomes cheaper.
TEST(MapThinning, APlanCountsWhatIsGoneAlready) {
  const PointScene scene = PointScene::wall();
  SceneMap world(scene);
  world.add_key_frames(20);
  const auto map = world.shared.write();
  const auto any = [](KeyFrameId) { return true; };
  for (const KeyFrameId& planned : expendable_key_frames(*map, 12, any)) {
    EXPECT_EQ(expendable_key_frames(*map, 1, any), std::vector{planned});
    map->erase_key_frame(planned);
  }
}

TEST(MapThinning, PointsGoWhereThereAreMany) {
  const PointScene scene = PointScene::wall();
  SceneMap world(scene);
  world.add_key_frames(6, 0, 0);
  world.add_key_frames(2, 3, 3);
  const auto map = world.shared.write();
  const size_t before = map->point_count();
  thin_points(*map, before);
  EXPECT_EQ(map->point_count(), before);
  const auto seen = [&] {
    std::vector<int> counts;
    for (const KeyFrameId& id : map->key_frames())
      counts.push_back(static_cast<int>(points_of(*map, std::array{id}).size()));
    return *std::min_element(counts.begin(), counts.end());
  };
  thin_points(*map, before / 4);
  EXPECT_EQ(map->check(), "");
  EXPECT_EQ(map->point_count(), before / 4);
  EXPECT_EQ(map->key_frame_count(), 8u);
  EXPECT_GT(seen(), static_cast<int>(before) / 16) << "in every key frame";
  thin_points(*map, 0);
  EXPECT_EQ(map->point_count(), 0u);
  EXPECT_EQ(map->check(), "");
}

}  // namespace
}  // namespace covis
