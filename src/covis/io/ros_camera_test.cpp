// SPDX-License-Identifier: Apache-2.0
#include "covis/io/ros_camera.h"

#include <Eigen/Geometry>

#include "covis/io/test_bags.h"

namespace covis::io {
namespace {

using testing::AllOf;
using testing::HasSubstr;

TEST(RosCamera, LensesByModel) {
  RosCameraInfo info = camera_info();
  EXPECT_EQ(raw_camera(info)->distortion, Distortion::none);
  info.D = {0.1, -0.2, 0.3, 0.4, 0.5};
  EXPECT_EQ(raw_camera(info)->distortion, Distortion::brown_conrady);
  EXPECT_EQ(raw_camera(info)->coefficients[4], 0.5);
  EXPECT_EQ(raw_camera(info)->pinhole.fx, 50);
  info.model = "rational_polynomial";
  info.D = {0.1, -0.2, 0.3, 0.4, 0.5, 0, 0, 0};
  EXPECT_EQ(raw_camera(info)->distortion, Distortion::brown_conrady);
  info.D[6] = 0.1;
  EXPECT_THAT(raw_camera(info).error().message, HasSubstr("rational_polynomial"));
  info.model = "equidistant";
  info.D = {0.1, -0.2, 0.3, 0.4};
  EXPECT_EQ(raw_camera(info)->distortion, Distortion::kannala_brandt);
  info.model = "thin_prism";
  EXPECT_THAT(raw_camera(info).error().message, AllOf(HasSubstr("'thin_prism'"), HasSubstr("plumb_bob")));
}

TEST(RosCamera, FieldsThatCantBeUsed) {
  RosCameraInfo info = camera_info();
  info.width = 0;
  EXPECT_THAT(raw_camera(info).error().message, HasSubstr("width"));
  info = camera_info();
  info.binning_x = 2;
  EXPECT_THAT(raw_camera(info).error().message, HasSubstr("binning_x"));
  info = camera_info();
  info.K[1] = 5;
  EXPECT_THAT(raw_camera(info).error().message, HasSubstr("K has a skew (its second number is 5.000000)"));
  info = camera_info();
  info.P = {};
  EXPECT_THAT(rectified_camera(info).error().message, HasSubstr("P holds the focal lengths"));
  EXPECT_THAT(stereo_camera(camera_info(), camera_info(-5), StereoImages::rectified).error().message,
              HasSubstr("left and right exchanged"));
}

// R and P of both cameras give the pose that they were made from.
TEST(RosCamera, RawPairsAreRectifiedByTheirPose) {
  const Eigen::Matrix3d R_l = Eigen::AngleAxisd(0.03, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  const Eigen::Matrix3d R_r = Eigen::AngleAxisd(-0.02, Eigen::Vector3d(2, -1, 1).normalized()).toRotationMatrix();
  RosCameraInfo left = camera_info(), right = camera_info(10);
  Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(left.R.data()) = R_l;
  Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(right.R.data()) = R_r;
  const auto stereo = stereo_camera(left, right, StereoImages::raw);
  ASSERT_TRUE(stereo) << stereo.error().message;
  ASSERT_TRUE(stereo->rectification);
  EXPECT_NEAR(stereo->camera.pinhole.baseline(), 0.2, 1e-12);
  // The baseline, x of the rectified camera, is that of ROS's rectified camera too.
  const Eigen::Vector3d x = stereo->rectification->T_left_rectified().R() * Eigen::Vector3d::UnitX();
  EXPECT_LT((x - R_l.transpose() * Eigen::Vector3d::UnitX()).norm(), 1e-9);
  left.R = {1, 1, 0, 0, 1, 0, 0, 0, 1};
  EXPECT_THAT(stereo_camera(left, right, StereoImages::raw).error().message, HasSubstr("R of the left camera"));
}

TEST(RosCamera, PairsWithoutDistortionAndRotationStayAsTheyAre) {
  const auto stereo = stereo_camera(camera_info(), camera_info(10), StereoImages::raw);
  ASSERT_TRUE(stereo) << stereo.error().message;
  EXPECT_FALSE(stereo->rectification);
  EXPECT_NEAR(stereo->camera.pinhole.bf, 10, 1e-12);
  EXPECT_EQ(stereo->camera.pinhole.fy, 51);
}

}  // namespace
}  // namespace covis::io
