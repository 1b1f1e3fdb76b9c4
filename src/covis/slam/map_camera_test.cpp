// SPDX-License-Identifier: Apache-2.0
#include "covis/slam/map_camera.h"

#include <gtest/gtest.h>

#include "covis/map/map_state.h"
#include "covis/map/test_point_scene.h"

namespace covis {
namespace {

Camera camera_of(const Pinhole& pinhole) {
  Camera camera;
  camera.width = 640;
  camera.height = 480;
  camera.pinhole = pinhole;
  return camera;
}

struct MapCamera : testing::Test {
  const PointScene scene = PointScene::wall();
  const Pinhole stereo{500, 500, 320, 240, 50}, other{600, 600, 300, 250, 60};
  const DepthNoise noise{0.001, 0.002};

  Map map_of(const Pinhole& camera, Sensor sensor = Sensor::rgbd) const {
    SceneMap world{scene, sensor};
    world.add_key_frames(3);
    Map map = Map::from_state(world.shared.read()->state()).value();
    map.set_camera(camera);
    return map;
  }
};

TEST_F(MapCamera, WithoutDepthAMapInMetresIsNotContinued) {
  EXPECT_FALSE(check_continued(map_of(stereo), Sensor::monocular));
  EXPECT_TRUE(check_continued(map_of(stereo), Sensor::stereo));
  EXPECT_TRUE(check_continued(map_of({500, 500, 320, 240, 0}, Sensor::monocular), Sensor::monocular));
}

TEST_F(MapCamera, TheSameLensKeepsWhatWasRefined) {
  Pinhole refined = stereo;
  refined.fx = refined.fy = 510;
  refined.bf = refined.fx * stereo.baseline();
  const Map map = map_of(refined);
  EXPECT_EQ(camera_for(map, camera_of(stereo), camera_of(stereo), Sensor::stereo).fx, 510);
  Pinhole wider = stereo;
  wider.bf *= 2;
  const Pinhole camera = camera_for(map, camera_of(stereo), camera_of(wider), Sensor::stereo);
  EXPECT_EQ(camera.fx, 510) << "only the baseline is another";
  EXPECT_NEAR(camera.baseline(), 0.2, 1e-12);
  EXPECT_EQ(camera_for(map, camera_of(stereo), camera_of(other), Sensor::stereo).fx, 600);
}

TEST_F(MapCamera, ARegistrationThatWasGivenGoesBeforeTheOneFound) {
  Pinhole found = stereo;
  found.depth_noise = noise;
  found.registration.scale = 1.1;
  const Map map = map_of(found);
  const auto registration = [&](const Pinhole& given, Sensor sensor) {
    return camera_for(map, camera_of(stereo), camera_of(given), sensor).registration;
  };
  EXPECT_EQ(registration(stereo, Sensor::rgbd), found.registration);
  EXPECT_EQ(registration(stereo, Sensor::monocular), found.registration) << "for those that come after";
  EXPECT_FALSE(registration(other, Sensor::rgbd).any()) << "another camera has its own";
  Pinhole given = stereo;
  given.registration.shift_x = 12;
  EXPECT_EQ(registration(given, Sensor::rgbd), given.registration);
  EXPECT_EQ(registration(given, Sensor::monocular), found.registration) << "it measures no depth";
  EXPECT_FALSE(registration(stereo, Sensor::stereo).any());
}

TEST_F(MapCamera, RectifiedPairsHaveNoResidualDistortion) {
  Pinhole refined = stereo;
  refined.residual = {0.02, -0.01};
  const Map map = map_of(refined);
  EXPECT_EQ(camera_for(map, camera_of(stereo), camera_of(stereo), Sensor::monocular).residual, refined.residual);
  EXPECT_EQ(camera_for(map, camera_of(stereo), camera_of(stereo), Sensor::rgbd).residual, refined.residual);
  EXPECT_FALSE(camera_for(map, camera_of(stereo), camera_of(stereo), Sensor::stereo).residual.any());
  EXPECT_FALSE(camera_for(map, camera_of(stereo), camera_of(other), Sensor::monocular).residual.any());
}

TEST_F(MapCamera, WhatRectificationLeftIsOfThatPair) {
  Pinhole saved = stereo;
  saved.right_columns = {{0.1, 0.2}};
  const Map map = map_of(saved, Sensor::stereo);
  Pinhole wider = stereo;
  wider.bf = 60;
  EXPECT_EQ(camera_for(map, camera_of(stereo), camera_of(stereo), Sensor::stereo).right_columns, saved.right_columns);
  EXPECT_FALSE(camera_for(map, camera_of(stereo), camera_of(wider), Sensor::stereo).right_columns.any());
  EXPECT_FALSE(camera_for(map, camera_of(stereo), camera_of(other), Sensor::stereo).right_columns.any());
  EXPECT_FALSE(camera_for(map, camera_of(stereo), camera_of(stereo), Sensor::monocular).right_columns.any());
}

TEST_F(MapCamera, DepthsKeepWhatTheyWere) {
  Pinhole sensor = stereo;
  sensor.depth_noise = noise;
  // A camera without depth changes nothing of it.
  const Pinhole localised =
      camera_for(map_of(sensor), camera_of(sensor), camera_of({600, 600, 300, 250, 0}), Sensor::monocular);
  EXPECT_EQ(localised.fx, 600);
  EXPECT_NEAR(localised.baseline(), 0.1, 1e-12);
  EXPECT_EQ(localised.depth_noise, noise);
  // The depths of a stereo camera are not as good as those of a depth sensor.
  Pinhole kinect = other;
  kinect.depth_noise = noise;
  const Pinhole continued = camera_for(map_of(stereo), camera_of(stereo), camera_of(kinect), Sensor::rgbd);
  EXPECT_FALSE(continued.depth_noise.known());
  EXPECT_NEAR(continued.baseline(), stereo.baseline(), 1e-12);
  // … and a depth sensor's are good enough for disparities.
  const Pinhole by_stereo = camera_for(map_of(sensor), camera_of(sensor), camera_of(other), Sensor::stereo);
  EXPECT_FALSE(by_stereo.depth_noise.known());
  EXPECT_NEAR(by_stereo.baseline(), other.baseline(), 1e-12);
  EXPECT_EQ(camera_for(map_of(sensor), camera_of(sensor), camera_of(stereo), Sensor::rgbd).depth_noise, noise);
}

}  // namespace
}  // namespace covis
