// SPDX-License-Identifier: Apache-2.0
#include "covis/mapping/key_frame_insertion.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "covis/map/test_point_scene.h"

namespace covis {
namespace {

size_t valid_points(const std::vector<MapPointId>& points) {
  return static_cast<size_t>(std::count_if(points.begin(), points.end(), [](MapPointId id) { return id.valid(); }));
}

// Two key frames, to which others are added.
struct KeyFrameInsertionTest : testing::Test {
  void SetUp() override { world.add_key_frames(2); }
  KeyFrameId insert(const KeyFrameRequest& request) {
    const KeyFrameId id = insert_key_frame(world.shared, request, recent);
    EXPECT_EQ(world.shared.read()->check(), "");
    return id;
  }

  const PointScene scene = PointScene::wall();
  SceneMap world{scene};
  RecentPoints recent;
};

TEST_F(KeyFrameInsertionTest, ObservesWhatWasMatchedAndMakesPointsOfDepth) {
  const KeyFrameRequest request = world.request(4, world.frames[1]);
  const size_t before = world.shared.read()->point_count(), matched = valid_points(request.points);
  ASSERT_GT(matched, 100u);
  ASSERT_GT(request.new_points.size(), 10u);
  const KeyFrameId id = insert(request);
  const auto map = world.shared.read();
  ASSERT_TRUE(map->find(id));
  EXPECT_EQ(valid_points(map->at(id).points), matched + request.new_points.size());
  EXPECT_EQ(map->point_count(), before + request.new_points.size());
  EXPECT_EQ(recent.size(), request.new_points.size()) << "they are on probation";
  EXPECT_TRUE(map->at(id).parent.valid());
}

// A registration was found while the request was under way: some keypoints have no depth by it.
TEST_F(KeyFrameInsertionTest, MakesNoPointsOfDepthsThatAreGone) {
  ImageF half(640, 480);
  for (int y = 0; y < half.height(); ++y)
    for (int x = 0; x < half.width(); ++x) half(x, y) = x < 320 ? 5.0f : 0.0f;
  KeyFrameRequest request = world.request(4, world.frames[1]);
  request.depth = std::make_shared<const KeptDepth>(half.view());
  Pinhole camera = world.shared.read()->camera();
  camera.registration.shift_x = 2;
  world.shared.write()->set_camera(camera);
  const size_t before = world.shared.read()->point_count();
  const KeyFrameId id = insert(request);
  const auto map = world.shared.read();
  size_t made = 0;
  for (const uint32_t feature : request.new_points) {
    const MapPointId point = map->at(id).points[feature];
    EXPECT_EQ(point.valid(), map->at(id).features->has_depth(static_cast<int>(feature)));
    if (!point.valid()) continue;
    ++made;
    EXPECT_NEAR((map->at(id).T_cw * map->at(point).position_w).z(), 5, 0.01);
  }
  EXPECT_EQ(map->point_count(), before + made);
  EXPECT_LT(made, request.new_points.size());
}

TEST_F(KeyFrameInsertionTest, WithoutAReferenceItBeginsASubmap) {
  const KeyFrameId id = insert(scene_request(scene, world.shared, Sensor::rgbd, 4));
  const auto map = world.shared.read();
  EXPECT_EQ(map->submaps().size(), 2u);
  EXPECT_TRUE(map->is_root(id));
}

TEST_F(KeyFrameInsertionTest, AnErasedReferenceLeadsToItsParent) {
  world.add_key_frames(1, 2);
  const KeyFrameRequest request = world.request(4, world.frames[2]);
  ASSERT_TRUE(world.shared.write()->erase_key_frame(world.frames[2]));
  const KeyFrameId id = insert(request);
  ASSERT_TRUE(id.valid());
  EXPECT_LT((world.shared.read()->at(id).T_cw.t() - scene.T_cw(4).t()).norm(), 1e-9);
}

// Matches and counts go to the point that replaced the one they name; after the replacement is forgotten they are
// dropped.
TEST_F(KeyFrameInsertionTest, AReplacedPointIsFollowedUntilItIsForgotten) {
  KeyFrameRequest request = world.request(2, world.frames[1]);
  std::vector<uint32_t> matched;
  for (uint32_t f = 0; f < request.points.size(); ++f) {
    if (request.points[f].valid()) matched.push_back(f);
  }
  ASSERT_GE(matched.size(), 2u);
  const MapPointId old = request.points[matched[0]], by = request.points[matched[1]];
  request.counts = {{old, 5, 3}};
  ASSERT_TRUE(world.shared.write()->replace_point(old, by));
  const uint32_t visible = world.shared.read()->at(by).visible, found = world.shared.read()->at(by).found;

  const KeyFrameId followed = insert(request);
  EXPECT_EQ(world.shared.read()->at(followed).points[matched[0]], by);
  EXPECT_EQ(world.shared.read()->at(by).visible, visible + 5);
  EXPECT_EQ(world.shared.read()->at(by).found, found + 3);

  const uint32_t newest = world.shared.read()->next_serial();
  world.shared.write()->forget_forwarding(newest);
  const KeyFrameId forgotten = insert(request);
  EXPECT_FALSE(world.shared.read()->at(forgotten).points[matched[0]].valid());
  EXPECT_EQ(world.shared.read()->at(forgotten).points[matched[1]], by);
  EXPECT_EQ(world.shared.read()->at(by).visible, visible + 5);
}

}  // namespace
}  // namespace covis
