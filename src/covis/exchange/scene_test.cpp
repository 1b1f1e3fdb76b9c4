// SPDX-License-Identifier: Apache-2.0
#include "covis/exchange/scene.h"

#include "covis/exchange/test_scene.h"
#include "covis/features/straightening.h"
#include "covis/map/camera_change.h"

namespace covis::exchange {
namespace {

TEST(Scene, HoldsEachSubmapWithItsPointsAsTheyAreSeen) {
  const std::vector<Scene> scenes = ring_scenes();
  ASSERT_EQ(scenes.size(), 2u);
  EXPECT_EQ(scenes[0].views.size(), 8u) << "the larger one first";
  EXPECT_EQ(scenes[1].views.size(), 3u);
  for (const Scene& scene : scenes) {
    size_t keypoints = 0, sights = 0;
    for (const SceneView& view : scene.views) keypoints += view.keypoints.size();
    ASSERT_GT(scene.points.size(), 30u);
    for (const ScenePoint& point : scene.points) {
      EXPECT_LT(point.error, 1e-3);  // keypoints are single-precision
      sights += point.seen.size();
      for (const ScenePoint::Sight& sight : point.seen) {
        const SceneView& view = scene.views[sight.view];
        EXPECT_EQ(&scene.points[view.keypoints[sight.keypoint].point], &point);
        EXPECT_GT(point.normal.dot(view.T_cw.inverse().t() - point.position), 0) << "it is turned to who sees it";
      }
    }
    EXPECT_EQ(keypoints, sights);
    EXPECT_EQ(scene.views[0].image, image_name(scene.views[0].serial));
  }
}

TEST(Scene, LeavesOutWhatIsOutsideTheImage) {
  const PointScene points = PointScene::wall();
  SceneMap world(points, Sensor::rgbd);
  world.add_key_frames(2);
  const auto scene_of_width = [&](int width) {
    return scenes_of(*world.shared.read(), Camera{width, 480, points.camera, Distortion::none, {}})[0];
  };
  const size_t all = scene_of_width(640).views[0].keypoints.size();
  const Scene narrow = scene_of_width(320);
  EXPECT_LT(narrow.views[0].keypoints.size(), all);
  for (const SceneView::Keypoint& keypoint : narrow.views[0].keypoints) EXPECT_LT(keypoint.u, 319.5);
}

// Some key frames are of a camera of another focal length: their keypoints are in its own pixels again.
TEST(Scene, HasTheCamerasThatKeyFramesName) {
  const PointScene points = PointScene::wall();
  SceneMap world(points, Sensor::rgbd);
  world.add_key_frames(4);
  const Camera own{640, 480, points.camera, Distortion::none, {}};
  Camera other{1280, 960, {1000, 1000, 650, 470, 0}, Distortion::none, {}};
  MapState state = world.shared.read()->state();
  ASSERT_TRUE(express_in(state, own, {other, other.pinhole}));
  state.key_frames[0].features = world.shared.read()->state().key_frames[0].features->for_key_frame();
  const auto map = Map::from_state(std::move(state));
  ASSERT_TRUE(map) << map.error().message;
  const Scene scene = scenes_of(*map, other)[0];
  ASSERT_EQ(scene.cameras.size(), 2u);
  EXPECT_EQ(scene.cameras[0].given, other);
  EXPECT_EQ(scene.cameras[1].given, own);
  for (const SceneView& view : scene.views) EXPECT_EQ(view.camera, view.serial == 0 ? 0u : 1u);
  const SceneView& view = scene.views[2];
  ASSERT_GT(view.keypoints.size(), 100u);
  for (const SceneView::Keypoint& keypoint : view.keypoints) {
    const Eigen::Vector2d at = own.pinhole.project(view.T_cw * scene.points[keypoint.point].position);
    EXPECT_NEAR((at - Eigen::Vector2d(keypoint.u, keypoint.v)).norm(), 0, 1e-3);
    EXPECT_LT(keypoint.u, 640);
  }
  const Pinhole middle = centred(scene).cameras[1].pinhole;
  EXPECT_EQ(middle.cx, 319.5);
  EXPECT_EQ(centred(scene).cameras[0].pinhole.cx, 639.5);
}

// The first point from `from` on with so many sights.
uint32_t point_seen_by(const Scene& scene, size_t views, uint32_t from = 0) {
  while (scene.points.at(from).seen.size() != views) ++from;
  return from;
}

void move_sight(Scene& scene, uint32_t point, size_t sight, double pixels) {
  const auto [view, keypoint] = scene.points[point].seen[sight];
  scene.views[view].keypoints[keypoint].u += pixels;
}

size_t observations(const Scene& scene) {
  size_t count = 0;
  for (const SceneView& view : scene.views) count += view.keypoints.size();
  return count;
}

TEST(Scene, TellsWhereTheImageShowsWhatARollingShutterMoved) {
  const PointScene points = PointScene::wall();
  SceneMap world(points, Sensor::monocular);
  world.add_key_frames(2);
  Pinhole camera = points.camera;
  camera.row_time = 0.02 / 480;
  {
    const auto map = world.shared.write();
    map->set_features(world.frames[0], key_frame_features(*world.views[0].features, nullptr, {0.3, 1, -0.2}, camera));
    map->set_camera(camera);
  }
  const Camera given{640, 480, camera, Distortion::none, {}};
  const Scene scene = scenes_of(*world.shared.read(), given).front();
  double moved = 0;
  for (const SceneView::Keypoint& keypoint : scene.views[0].keypoints) {
    const Eigen::Vector2d shown = camera.project(points.T_cw(0) * scene.points[keypoint.point].position);
    EXPECT_LT((keypoint.in_image() - shown).norm(), 1e-3) << "points are where the keypoints were at first";
    moved = std::max(moved, keypoint.rolled.norm());
  }
  EXPECT_GT(moved, 3);
  for (const SceneView::Keypoint& keypoint : scene.views[1].keypoints) EXPECT_LT(keypoint.rolled.norm(), 1e-4);
  const Scene middle = centred(scene);
  for (size_t k = 0; k < scene.views[0].keypoints.size(); ++k) {
    const SceneView::Keypoint &before = scene.views[0].keypoints[k], &after = middle.views[0].keypoints[k];
    const Eigen::Vector3d ray = camera.unproject(before.in_image().x(), before.in_image().y());
    EXPECT_LT((middle.cameras[0].pinhole.project(ray) - after.in_image()).norm(), 1e-9);
  }
}

TEST(Scene, KeepsTheTracksOfPointsThatAreWhereTheyAreSeen) {
  Scene scene = ring_scenes()[0];
  keep_tracks(scene);
  for (SceneView& view : scene.views) {
    for (size_t k = 0; k < view.keypoints.size(); ++k) view.keypoints[k].v += k % 2 ? 0.5 : -0.5;  // noise
  }
  const uint32_t seen_often = point_seen_by(scene, 3), seen_twice = point_seen_by(scene, 2);
  const uint32_t behind = point_seen_by(scene, 3, seen_often + 1);
  move_sight(scene, seen_often, 1, 100);
  move_sight(scene, seen_twice, 0, -4.5);
  move_sight(scene, point_seen_by(scene, 2, seen_twice + 1), 0, 3.5);
  const SceneView& view = scene.views[scene.points[behind].seen[0].view];
  scene.points[behind].position = view.T_cw.inverse() * Eigen::Vector3d(0, 0, -5);
  const Scene before = scene;

  const LeftOut left_out = keep_tracks(scene);
  EXPECT_EQ(left_out.points, 2u) << "the one behind cameras, and the one that a single view is left to see";
  EXPECT_EQ(scene.points.size(), before.points.size() - 2);
  EXPECT_EQ(left_out.observations, 1u + 1u + 3u);
  EXPECT_EQ(observations(scene), observations(before) - left_out.observations - 1);
  const uint32_t now = seen_often - (seen_twice < seen_often) - (behind < seen_often);
  EXPECT_EQ(scene.points[now].position, before.points[seen_often].position);
  EXPECT_EQ(scene.points[now].seen.size(), 2u);
  for (size_t v = 0; v < scene.views.size(); ++v) EXPECT_EQ(scene.views[v].T_cw.t(), before.views[v].T_cw.t());
  for (const ScenePoint& point : scene.points) {
    ASSERT_GE(point.seen.size(), 2u);
    EXPECT_LE(point.error, 0.5 + 3.5 / 2);
    for (const ScenePoint::Sight& sight : point.seen)
      EXPECT_EQ(&scene.points[scene.views[sight.view].keypoints[sight.keypoint].point], &point);
  }
  EXPECT_NEAR(mean_error(scene), 0.5, 0.05);
  EXPECT_EQ(keep_tracks(scene).observations, 0u);
}

TEST(Scene, HasAnUpwardDirectionAndAViewFromAbove) {
  const Scene scene = ring_scenes()[0];
  EXPECT_TRUE(upward(scene).isApprox(Eigen::Vector3d(0, -1, 0), 1e-9)) << "its cameras are held level, y is down";
  const Eigen::Matrix3d R = seen_from_above(scene);
  EXPECT_NEAR(R.determinant(), 1, 1e-12);
  EXPECT_TRUE((R * Eigen::Vector3d(0, -1, 0)).isApprox(Eigen::Vector3d::UnitZ(), 1e-12));
  const Eigen::Vector3d ahead = scene.views[0].T_cw.R().row(2), right = scene.views[0].T_cw.R().row(0);
  EXPECT_TRUE((R * ahead).isApprox(Eigen::Vector3d::UnitY(), 1e-12));
  EXPECT_TRUE((R * right).isApprox(Eigen::Vector3d::UnitX(), 1e-12));
}

}  // namespace
}  // namespace covis::exchange
