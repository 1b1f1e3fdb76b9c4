// SPDX-License-Identifier: Apache-2.0
// The scene that other tests are made of.
#include <gtest/gtest.h>

#include "covis/map/test_point_scene.h"

namespace covis {
namespace {

TEST(PointScene, AViewShowsItsPointsWhereTheyAre) {
  const PointScene scene = PointScene::wall();
  const PointScene::View view = scene.view(scene.T_cw(3));
  ASSERT_GT(view.point.size(), 150u);
  ASSERT_EQ(view.point.size(), static_cast<size_t>(view.features->size()));
  for (size_t f = 0; f < view.point.size(); ++f) {
    const Eigen::Vector3d p_c = scene.T_cw(3) * scene.points[view.point[f]].position_w;
    EXPECT_NEAR(view.features->x[f], scene.camera.project(p_c).x(), 1e-3);
    EXPECT_NEAR(view.features->depth[f], p_c.z(), 1e-5);
    EXPECT_NEAR(view.features->u_right[f], view.features->x[f] - scene.camera.bf / p_c.z(), 1e-3);
    EXPECT_EQ(view.features->descriptor[f], scene.points[view.point[f]].descriptor);
  }
}

TEST(PointScene, ThereIsNoDepthForOneEye) {
  const PointScene scene = PointScene::wall();
  const PointScene::View view = scene.view(scene.T_cw(0), Sensor::monocular);
  for (int f = 0; f < view.features->size(); ++f) EXPECT_FALSE(view.features->has_depth(f));
}

TEST(PointScene, ItsMapIsWhole) {
  const PointScene scene = PointScene::ring();
  SceneMap world(scene);
  world.add_key_frames(12, 0, 4);
  const auto map = world.shared.read();
  EXPECT_EQ(map->check(), "");
  EXPECT_EQ(map->key_frame_count(), 12u);
  EXPECT_GT(map->weight(world.frames[0], world.frames[1]), 30);
  EXPECT_GT(map->weight(world.frames[0], world.frames[11]), 30) << "the camera is back";
  EXPECT_EQ(map->weight(world.frames[0], world.frames[6]), 0) << "it looks the other way there";
}

TEST(PointScene, ForgottenPointsAreSeenAnew) {
  const PointScene scene = PointScene::wall();
  SceneMap world(scene);
  world.add_key_frames(1);
  world.forget_points();
  world.add_key_frames(1);
  EXPECT_EQ(world.shared.read()->weight(world.frames[0], world.frames[1]), 0);
  EXPECT_EQ(world.shared.read()->check(), "");
}

TEST(PointScene, ARequestKnowsThePointsOfTheMap) {
  const PointScene scene = PointScene::wall();
  SceneMap world(scene);
  world.add_key_frames(1);
  const KeyFrameRequest r = world.request(3, world.frames[0]);
  EXPECT_GT(std::count_if(r.points.begin(), r.points.end(), [](MapPointId id) { return id.valid(); }), 100);
  EXPECT_GT(r.new_points.size(), 10u);
  EXPECT_LT((r.pose.T_cw(*world.shared.read()).inverse().t() - scene.T_wc_of(3).t()).norm(), 1e-9);
}

}  // namespace
}  // namespace covis
