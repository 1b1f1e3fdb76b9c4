// SPDX-License-Identifier: Apache-2.0
#include "covis/map/camera_change.h"

#include <gtest/gtest.h>

#include "covis/features/straightening.h"
#include "covis/map/test_point_scene.h"

namespace covis {
namespace {

// A camera of another size, focal length and baseline, that sees twice as many pixels of the same.
const Pinhole kFine{1000, 1000, 650, 470, 200};

RefinedCamera camera_of(const Pinhole& pinhole) { return {{640, 480, pinhole, Distortion::none, {}}, pinhole}; }

struct CameraChange : testing::Test {
  CameraChange() { world.add_key_frames(8); }
  MapState expressed(const Pinhole& camera) const {
    MapState state = world.shared.read()->state();
    EXPECT_TRUE(express_in(state, camera_of(state.camera).given, camera_of(camera)));
    return state;
  }
  const PointScene scene = PointScene::wall();
  SceneMap world{scene};
};

TEST_F(CameraChange, PointsProjectToWhereTheirKeypointsAre) {
  const auto map = Map::from_state(expressed(kFine));
  ASSERT_TRUE(map) << map.error().message;
  EXPECT_EQ(map->check(), "");
  EXPECT_EQ(map->camera(), kFine);
  for (const KeyFrameId& id : map->key_frames()) {
    const KeyFrame& key_frame = map->at(id);
    const Features& f = *key_frame.features;
    for (size_t i = 0; i < key_frame.points.size(); ++i) {
      if (!key_frame.points[i].valid()) continue;
      const Eigen::Vector3d p_c = key_frame.T_cw * map->at(key_frame.points[i]).position_w;
      EXPECT_NEAR((kFine.project(p_c) - Eigen::Vector2d(f.x[i], f.y[i])).norm(), 0, 1e-3);
      EXPECT_NEAR(f.u_right[i], f.x[i] - kFine.bf / p_c.z(), 1e-3);
      EXPECT_NEAR(f.image_x()[i], scene.camera.project(p_c).x(), 1e-3) << "it stays where it is in its image";
    }
  }
}

// A keypoint keeps its level, and the noise of a pixel that is as large as two of the other camera.
TEST_F(CameraChange, LevelsAndNoiseAreThoseOfTheOldPixels) {
  const auto map = Map::from_state(expressed(kFine));
  ASSERT_TRUE(map);
  for (const KeyFrameId& id : map->key_frames()) {
    const KeyFrame& key_frame = map->at(id);
    const Features& f = *key_frame.features;
    EXPECT_EQ(f.pyramid->base, 2);
    EXPECT_EQ(f.pyramid->sigma2[0], 4);
    for (size_t i = 0; i < key_frame.points.size(); ++i) {
      if (!key_frame.points[i].valid()) continue;
      const MapPoint& point = map->at(key_frame.points[i]);
      const double distance = (point.position_w - key_frame.T_cw.centre()).norm();
      EXPECT_LE(std::abs(f.pyramid->predict_level(point.d_max, static_cast<float>(distance)) - f.level[i]), 1);
    }
  }
}

TEST_F(CameraChange, ThereAndBackIsTheSame) {
  MapState state = expressed(kFine);
  EXPECT_TRUE(express_in(state, camera_of(state.camera).given, camera_of(scene.camera)));
  const MapState before = world.shared.read()->state();
  ASSERT_EQ(state.points.size(), before.points.size());
  for (size_t p = 0; p < before.points.size(); ++p) EXPECT_NEAR(state.points[p].d_max, before.points[p].d_max, 1e-4);
  for (size_t k = 0; k < before.key_frames.size(); ++k) {
    const Features &f = *state.key_frames[k].features, &g = *before.key_frames[k].features;
    EXPECT_EQ(f.pyramid->base, 1);
    for (size_t i = 0; i < g.x.size(); ++i) EXPECT_NEAR(f.x[i], g.x[i], 1e-3);
  }
}

TEST_F(CameraChange, KeyFramesNameTheirCameraUnlessItIsTheMapsOwn) {
  const Camera first = camera_of(scene.camera).given, fine = camera_of(kFine).given;
  MapState state = world.shared.read()->state();
  EXPECT_TRUE(other_cameras(state).empty());
  state.camera.fx *= 1.01;  // as it was refined
  const Pinhole refined = state.camera;
  ASSERT_TRUE(express_in(state, first, {fine, kFine}));
  EXPECT_EQ(other_cameras(state), (std::vector<RefinedCamera>{{first, refined}}));
  const auto map = Map::from_state(state);
  ASSERT_TRUE(map);
  EXPECT_TRUE(has_other_cameras(*map));
  // A third camera: the first key frames still name the first.
  Camera third = first;
  third.distortion = Distortion::brown_conrady;
  third.coefficients[0] = -0.1;
  state.key_frames.back().features = world.shared.read()->state().key_frames.back().features;  // as if the map's own
  ASSERT_TRUE(express_in(state, fine, {third, third.pinhole}));
  EXPECT_EQ(other_cameras(state), (std::vector<RefinedCamera>{{first, refined}, {fine, kFine}}));
  // And back: they are the map's own again where it is refined as it was.
  ASSERT_TRUE(express_in(state, third, {first, refined}));
  EXPECT_EQ(other_cameras(state), (std::vector<RefinedCamera>{{fine, kFine}}));
  EXPECT_EQ(state.key_frames.front().features->made_by, nullptr);
  EXPECT_FALSE(has_other_cameras(*world.shared.read()));
}

// The keypoints that another camera gets have the rays that they had, so none of its own distortion is in them.
TEST_F(CameraChange, AResidualDistortionStaysWithItsCamera) {
  MapState state = world.shared.read()->state();
  const Camera first = camera_of(scene.camera).given;
  state.camera.residual = {0.05, -0.01};
  const Pinhole refined = state.camera;
  const FeaturesPtr before = state.key_frames.front().features;
  ASSERT_TRUE(express_in(state, first, camera_of(kFine)));
  EXPECT_EQ(state.camera, kFine);
  const Features& made = *state.key_frames.front().features;
  EXPECT_TRUE(straight_for(made, kFine));
  ASSERT_TRUE(made.made_by);
  EXPECT_EQ(made.made_by->pinhole, refined);
  for (size_t i = 0; i < made.x.size(); ++i) {
    EXPECT_NEAR((made.x[i] - kFine.cx) / kFine.fx, (before->x[i] - refined.cx) / refined.fx, 1e-6);
  }
  ASSERT_TRUE(express_in(state, camera_of(kFine).given, {first, refined}));
  EXPECT_TRUE(straight_for(*state.key_frames.front().features, refined));
  EXPECT_FALSE(state.key_frames.front().features->made_by);
}

// Maps of one camera that was refined in two ways, before they are merged.
TEST_F(CameraChange, StraighteningGivesAMapTheCameraRefinedInAnotherWay) {
  MapState state = world.shared.read()->state();
  const FeaturesPtr before = state.key_frames.front().features;
  Pinhole found = state.camera;
  found.residual = {0.05, -0.01};
  straighten(state, found);
  const auto map = Map::from_state(state);
  ASSERT_TRUE(map) << map.error().message;
  EXPECT_EQ(map->check(), "");
  EXPECT_EQ(map->camera(), found);
  const Features& straight = *state.key_frames.front().features;
  for (size_t i = 0; i < straight.x.size(); ++i) {
    EXPECT_NEAR(straight.x[i], found.straightened({before->x[i], before->y[i]})->x(), 1e-3);
  }
  straighten(state, scene.camera);
  for (size_t i = 0; i < before->x.size(); ++i) {
    EXPECT_NEAR(state.key_frames.front().features->x[i], before->x[i], 1e-3);
  }
}

TEST_F(CameraChange, CamerasThatDifferByTooMuchAreRefused) {
  MapState state = world.shared.read()->state();
  for (const Pinhole& camera :
       {Pinhole{500e3, 500e3, 320, 240, 50}, Pinhole{1, 1, 0, 0, 50}, Pinhole{500, 500, 1e9, 240, 50}}) {
    const auto done = express_in(state, camera_of(state.camera).given, camera_of(camera));
    ASSERT_FALSE(done);
    EXPECT_EQ(state.camera, scene.camera);
    EXPECT_EQ(state.key_frames[0].features, world.shared.read()->state().key_frames[0].features);
  }
  EXPECT_FALSE(has_other_pixels(state));
  EXPECT_TRUE(express_in(state, camera_of(state.camera).given, camera_of(kFine)));
  EXPECT_TRUE(has_other_pixels(state));
  Pinhole shifted = scene.camera;
  shifted.cx += 5;
  EXPECT_TRUE(express_in(state, camera_of(state.camera).given, camera_of(shifted)));
  EXPECT_FALSE(has_other_pixels(state)) << "there and back again";
}

TEST_F(CameraChange, SubmapsWithDepthAreInMetres) {
  EXPECT_EQ(metric_submaps(*world.shared.read()), std::vector<uint32_t>{0});
  world.sensor = Sensor::monocular;
  world.begin_submap();
  world.add_key_frames(4);
  world.sensor = Sensor::rgbd;
  world.begin_submap();
  world.add_key_frames(4);
  EXPECT_EQ(metric_submaps(*world.shared.read()), (std::vector<uint32_t>{0, 2}));
}

}  // namespace
}  // namespace covis
