// SPDX-License-Identifier: Apache-2.0
#include "covis/exchange/scene.h"

#include "covis/exchange/test_scene.h"

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
  const size_t all = scenes_of(*world.shared.read(), 640, 480)[0].views[0].keypoints.size();
  const Scene narrow = scenes_of(*world.shared.read(), 320, 480)[0];
  EXPECT_LT(narrow.views[0].keypoints.size(), all);
  for (const SceneView::Keypoint& keypoint : narrow.views[0].keypoints) EXPECT_LT(keypoint.u, 319.5);
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
