// SPDX-License-Identifier: Apache-2.0
#include "covis/map/key_frame_view.h"

#include <gtest/gtest.h>

#include "covis/map/test_point_scene.h"

namespace covis {
namespace {

TEST(KeyFrameView, IsTheKeyFrameWithoutTheMap) {
  const PointScene scene = PointScene::wall();
  SceneMap world(scene);
  world.add_key_frames(2);
  KeyFrameView view;
  {
    const auto map = world.shared.read();
    view.copy(*map, world.frames[1]);
    const KeyFrame& key_frame = map->at(world.frames[1]);
    EXPECT_EQ(view.id, world.frames[1]);
    EXPECT_EQ(view.submap, key_frame.submap);
    EXPECT_EQ(view.features, key_frame.features);
    EXPECT_EQ(view.points, key_frame.points);
    for (size_t i = 0; i < view.points.size(); ++i) EXPECT_EQ(view.positions[i], map->at(view.points[i]).position_w);
  }
  const Eigen::Vector3d before = view.T_cw.t();
  world.shared.write()->set_pose(world.frames[1], SE3());
  EXPECT_EQ(view.T_cw.t(), before);
}

TEST(KeyFrameView, TellsFeaturesWithAPointFromThoseWithout) {
  const std::vector<MapPointId> points{{1, 0}, {}, {2, 0}};
  EXPECT_EQ(features_with_point(points), (std::vector<uint8_t>{1, 0, 1}));
  EXPECT_EQ(features_without_point(points), (std::vector<uint8_t>{0, 1, 0}));
}

TEST(KeyFrameView, ItsMedianDepthIsThatOfItsPoints) {
  const PointScene scene = PointScene::wall();
  SceneMap world(scene);
  world.add_key_frames(1);
  EXPECT_NEAR(median_depth(KeyFrameView(*world.shared.read(), world.frames[0])), 6, 0.5) << "from 4 to 8 metres";
  EXPECT_EQ(median_depth(KeyFrameView()), 0);
}

}  // namespace
}  // namespace covis
