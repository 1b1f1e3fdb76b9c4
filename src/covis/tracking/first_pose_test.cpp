// SPDX-License-Identifier: Apache-2.0
#include "covis/tracking/first_pose.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "covis/tracking/test_frame.h"
#include "covis/tracking/test_panorama.h"

namespace covis {
namespace {

// A camera that looks outward from a circle; the last frame shows points of the map.
class FirstPoseTest : public testing::Test {
 protected:
  FirstPoseTest() {
    world.add_key_frames(24, 0, 2);
    last = frame_of(last_view, turned(0), 1);
    match_points(last, last_view, world);
    search.refresh_camera(*world.shared.read());
  }

  // The camera's pose turned by so many degrees since the last frame, with a small step.
  static SE3 turned(double degrees) {
    const double angle = 0.1 + degrees * std::numbers::pi / 180;
    return SE3(so3_exp({0, angle, 0}), {2 * std::sin(angle), 0, 2 * std::cos(angle)}).inverse();
  }
  // Finds the pose of a frame at T_cw, when the motion is expected to be T_cl.
  bool find(const SE3& T_cw, const std::optional<SE3>& T_cl) {
    const PointScene::View view = scene.view(T_cw);
    frame = frame_of(show_images ? with_image(view, T_cw) : view, SE3(), 2);
    result = {};
    return first_pose.find(last, T_cl, frame, search, result);
  }
  bool finds(const SE3& T_cw, const std::optional<SE3>& T_cl) {
    if (!find(T_cw, T_cl)) return false;
    EXPECT_LT(distance(frame.T_cw, T_cw), 0.05);
    return true;
  }
  // The view with a small image of what lies at infinity.
  PointScene::View with_image(const PointScene::View& view, const SE3& T_cw) const {
    return edited(view, [&](Features& f) {
      const Pinhole& camera = scene.camera;
      ImageU8 image(static_cast<int>(2 * camera.cx), static_cast<int>(2 * camera.cy));
      for (int y = 0; y < image.height(); ++y) {
        for (int x = 0; x < image.width(); ++x) {
          const double grey = far.grey(T_cw.R().transpose() * camera.unproject(x, y));
          image(x, y) = static_cast<uint8_t>(std::clamp(std::lround(grey), 0l, 255l));
        }
      }
      SmallImageMaker().make(image.view(), f.small);
    });
  }
  void know_reference(size_t key_frame) {
    const auto map = world.shared.read();
    search.local_map.reference.copy(*map, map->key_frames()[key_frame]);
  }

  const PointScene scene = PointScene::ring();
  SceneMap world{scene};
  const PointScene::View last_view = scene.view(turned(0));
  const Panorama far{7};
  bool show_images = false;
  TrackedFrame last, frame;
  TrackResult result;
  PoseSearch search{RecoveryOptions{}, Subject::stream};
  FirstPose first_pose{Sensor::rgbd, FirstPoseOptions{}, FirstPose::Support::map_points, 0};
};

TEST_F(FirstPoseTest, ARightPredictionIsEnough) {
  const SE3 T_cl = turned(1) * turned(0).inverse();
  ASSERT_TRUE(finds(turned(1), T_cl));
  EXPECT_EQ(result.method, TrackMethod::motion_model);
  EXPECT_GT(result.first_share, 0.5);
  EXPECT_FALSE(first_pose.images_agree(T_cl)) << "the images were not asked";
}

TEST_F(FirstPoseTest, ASuddenTurnIsFoundByDescriptors) {
  for (const double degrees : {-20.0, -8.0, 8.0, 20.0}) {
    ASSERT_TRUE(finds(turned(degrees), SE3())) << degrees << " degrees";
    EXPECT_EQ(result.method, TrackMethod::last_frame);
    EXPECT_GT(result.first_share, 0.5);
  }
}

// Where descriptors say nothing, the images lead to the search's place.
TEST_F(FirstPoseTest, ASuddenTurnIsFoundByTheImages) {
  show_images = true;
  last = frame_of(with_image(last_view, turned(0)), turned(0), 1);
  match_points(last, last_view, world);
  const SE3 T_cl = turned(12) * turned(0).inverse();
  ASSERT_TRUE(finds(turned(12), SE3()));
  EXPECT_EQ(result.method, TrackMethod::image_rotation);
  EXPECT_TRUE(first_pose.images_agree(T_cl));
  EXPECT_FALSE(first_pose.images_agree(SE3())) << "12 degrees beside";
}

TEST_F(FirstPoseTest, WithoutAPredictionTheReferenceKeyFrameServes) {
  know_reference(1);
  ASSERT_TRUE(finds(turned(2), std::nullopt));
  EXPECT_EQ(result.method, TrackMethod::reference_key_frame);
}

TEST_F(FirstPoseTest, WithoutAPredictionOrAReferenceTheLastFrameServes) {
  ASSERT_TRUE(finds(turned(2), std::nullopt));
  EXPECT_EQ(result.method, TrackMethod::last_frame);
}

TEST_F(FirstPoseTest, AViewOfSomethingElseHasNoPose) {
  know_reference(1);
  EXPECT_FALSE(find(turned(180), SE3()));
  EXPECT_EQ(result.method, TrackMethod::none);
  EXPECT_NE(result.reason, NoPoseReason::none);
}

TEST_F(FirstPoseTest, DepthOfTheLastFrameAloneCarriesAPoseOnlyInLocalisation) {
  for (auto& source : last.source) {
    if (source == PointSource::map) source = PointSource::depth;
  }
  EXPECT_FALSE(find(turned(1), turned(1) * turned(0).inverse()));
  FirstPose in_localisation(Sensor::rgbd, {}, FirstPose::Support::all_points, 0);
  EXPECT_TRUE(in_localisation.find(last, turned(1) * turned(0).inverse(), frame, search, result));
}

}  // namespace
}  // namespace covis
