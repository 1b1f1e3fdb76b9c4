// SPDX-License-Identifier: Apache-2.0
#include "covis/matching/point_fuser.h"

#include <gtest/gtest.h>

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

TEST_F(PointFuserTest, AStaleTargetIsLeft) { EXPECT_EQ(fuser.fuse(world.shared, KeyFrameId{77, 0}, points, {}), 0); }

}  // namespace
}  // namespace covis
