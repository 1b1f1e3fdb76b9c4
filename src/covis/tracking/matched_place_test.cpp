// SPDX-License-Identifier: Apache-2.0
// Matches as evidence of a place.
#include <gtest/gtest.h>

#include "covis/map/test_map.h"
#include "covis/tracking/place_check.h"
#include "covis/tracking/test_frame.h"

namespace covis {
namespace {

class LooksTest : public testing::Test {
 protected:
  LooksTest() { world.add_key_frames(3, 0, 2); }

  // Every point was in view of so many frames, and this share of them matched it.
  void seen_often(uint32_t frames, double share = 1) {
    const auto map = world.shared.write();
    for (const MapPointId id : map->points()) {
      map->count_visible(id, frames - 1);
      map->count_found(id, static_cast<uint32_t>(share * frames) - 1);
    }
  }
  // Judges a frame at this pose with every `every`-th of the points in view matched. The camera was there before, or
  // came from somewhere else.
  enum class Before { there, elsewhere };
  bool is_right(const SE3& T_cw, size_t every, Before before, Arrival arrival = Arrival::tracked) {
    if (before == Before::there) {
      place.restart_at(frame_of(scene.view(T_cw), T_cw), 0);
    } else {
      place.restart();
    }
    const PointScene::View view = scene.view(T_cw);
    TrackedFrame frame = frame_of(view, T_cw);
    match_points(frame, view, world, every);
    LocalMap local_map;
    local_map.update(*world.shared.read(), {}, world.frames[1], 80);
    std::vector<uint8_t> in_view;
    for (size_t k = 0; k < local_map.points.size(); ++k) {
      const Eigen::Vector2d pixel = scene.camera.project(T_cw * local_map.points.position(k));
      in_view.push_back(scene.bounds.contains(static_cast<float>(pixel.x()), static_cast<float>(pixel.y())));
    }
    const bool right = place.is_right({frame, local_map, in_view, &world.shared}, arrival);
    if (right) place.accept(frame, 0);
    return right;
  }

  const PointScene scene = PointScene::wall();
  SceneMap world{scene};
  PlaceCheck place{RecoveryOptions{}, Subject::stream};
};

TEST_F(LooksTest, ARightPlaceShowsWhatIsUsuallySeenFromThere) {
  seen_often(10, 0.8);
  EXPECT_TRUE(is_right(scene.T_cw(2), 1, Before::elsewhere, Arrival::relocalised));
  EXPECT_TRUE(place.tentative());
  EXPECT_TRUE(is_right(scene.T_cw(2), 2, Before::elsewhere)) << "half of what matches 0.8 of the time";
}

TEST_F(LooksTest, ALookAlikeShowsTheThingAndNotWhatStandsAroundIt) {
  seen_often(10);
  EXPECT_FALSE(is_right(scene.T_cw(2), 4, Before::elsewhere, Arrival::relocalised));
  EXPECT_FALSE(place.tentative()) << "nothing came of it";
  EXPECT_FALSE(is_right(scene.T_cw(2), 4, Before::there)) << "nor is it believed of a camera that was there";
}

TEST_F(LooksTest, MoreIsAskedAfterAJump) {
  seen_often(10);
  EXPECT_TRUE(is_right(scene.T_cw(2), 3, Before::there));
  EXPECT_FALSE(is_right(scene.T_cw(2), 3, Before::elsewhere));
}

TEST_F(LooksTest, AJumpBornOutByTheMapIsNotTentativeUnlessTheCameraWasLost) {
  seen_often(10);
  EXPECT_TRUE(is_right(scene.T_cw(2), 1, Before::elsewhere, Arrival::tracked));
  EXPECT_FALSE(place.tentative());
  EXPECT_TRUE(is_right(scene.T_cw(2), 1, Before::elsewhere, Arrival::relocalised));
  EXPECT_TRUE(place.tentative());
}

TEST_F(LooksTest, PointsThatSeldomMatchAreNotExpectedTo) {
  seen_often(20, 0.3);
  EXPECT_TRUE(is_right(scene.T_cw(2), 4, Before::elsewhere));
}

TEST_F(LooksTest, YoungPointsTellLess) {
  EXPECT_TRUE(is_right(scene.T_cw(2), 4, Before::elsewhere)) << "as many as that would be too few of known points";
  EXPECT_FALSE(is_right(scene.T_cw(2), 20, Before::elsewhere));
}

TEST_F(LooksTest, FromTheSameSideAQuarterServes) {
  seen_often(10);
  const SE3 aside = SE3(so3_exp({0, 0.2, 0}), Eigen::Vector3d(-1.6, 0, 0)) * scene.T_cw(4);  // by some 15 degrees
  EXPECT_TRUE(is_right(aside, 4, Before::elsewhere));
  EXPECT_FALSE(is_right(aside, 10, Before::elsewhere));
}

TEST_F(LooksTest, MoreIsAskedOfASingleImage) {
  seen_often(10);
  const SE3 aside = SE3(so3_exp({0, 0.2, 0}), Eigen::Vector3d(-1.6, 0, 0)) * scene.T_cw(4);
  EXPECT_TRUE(is_right(aside, 5, Before::elsewhere));
  PlaceCheck image{RecoveryOptions{}, Subject::single_image};
  const PointScene::View view = scene.view(aside);
  TrackedFrame frame = frame_of(view, aside);
  match_points(frame, view, world, 5);
  LocalMap local_map;
  local_map.update(*world.shared.read(), {}, world.frames[1], 80);
  const std::vector<uint8_t> in_view(local_map.points.size(), 1);
  EXPECT_FALSE(image.is_right({frame, local_map, in_view, &world.shared}, Arrival::relocalised));
}

TEST_F(LooksTest, WhatWasNeverSeenFromThereBearsOutNoJump) {
  seen_often(10);
  const SE3 behind = SE3(so3_exp({0, 3.1, 0}), Eigen::Vector3d(0, 0, 12)) * scene.T_cw(2);
  EXPECT_TRUE(is_right(behind, 1, Before::there));
  EXPECT_FALSE(is_right(behind, 1, Before::elsewhere));
}

TEST_F(LooksTest, AskedForNothingAnyPlaceIsRight) {
  seen_often(10);
  RecoveryOptions options;
  options.min_expected_match_ratio = 0;
  PlaceCheck easy(options, Subject::stream);
  const PointScene::View view = scene.view(scene.T_cw(2));
  const TrackedFrame frame = frame_of(view, scene.T_cw(2));
  LocalMap local_map;
  local_map.update(*world.shared.read(), {}, world.frames[1], 80);
  const std::vector<uint8_t> in_view(local_map.points.size(), 1);
  EXPECT_TRUE(easy.is_right({frame, local_map, in_view, &world.shared}, Arrival::relocalised));
}

TEST(WellDetermined, ByThePixelsThatThePositionsDeviationMoves) {
  const Pinhole camera{500, 500, 320, 240, 0};
  const auto information = [](double sigma) {
    Matrix6d m = Matrix6d::Identity();
    m.topLeftCorner<3, 3>() *= 3 / (sigma * sigma);  // a third of the variance for each axis
    return m;
  };
  EXPECT_TRUE(well_determined(information(0.0199), 5, camera)) << "500 x 0.02 / 5 are two pixels";
  EXPECT_FALSE(well_determined(information(0.0201), 5, camera));
  EXPECT_TRUE(well_determined(information(0.0201), 6, camera));
  EXPECT_FALSE(well_determined(Matrix6d::Zero(), 5, camera)) << "nothing is known";
}

}  // namespace
}  // namespace covis
