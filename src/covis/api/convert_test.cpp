// SPDX-License-Identifier: Apache-2.0
#include "covis/api/convert.h"

#include <gtest/gtest.h>

#include "covis/core/random.h"
#include "covis/geometry/lie.h"

namespace covis {
namespace {

SE3 random_pose(Random& random) {
  const auto draw = [&] { return Eigen::Vector3d(random.normal(), random.normal(), random.normal()); };
  return SE3(so3_exp(draw()), draw());
}

TEST(Convert, APoseComesBack) {
  Random random(1);
  for (int k = 0; k < 10; ++k) {
    const SE3 T = random_pose(random), back = to_se3(to_pose(T));
    EXPECT_LT((T.t() - back.t()).norm(), 1e-12);
    EXPECT_LT((T.R() - back.R()).norm(), 1e-12);
  }
}

TEST(Convert, TheCameraInUseHasTheDistortionThatWasFound) {
  const CameraParameters given{.width = 640, .height = 480, .fx = 500, .fy = 510, .cx = 320, .cy = 240};
  Pinhole now = to_camera(given, SensorType::monocular).pinhole;
  EXPECT_EQ(in_use(given, now).lens, LensType::none);
  now.residual = {0.02, -0.01};
  const CameraParameters used = in_use(given, now);
  EXPECT_EQ(used.lens, LensType::brown_conrady);
  EXPECT_EQ(used.distortion[0], 0.02);
  EXPECT_EQ(used.distortion[1], -0.01);
  EXPECT_EQ(used.distortion[2], 0);
  now.registration.shift_x = 4;  // the map has it that the camera is localised in
  EXPECT_EQ(in_use(given, now).depth_fx, 0);
}

TEST(Convert, TheCameraInUseHasTheReadoutThatWasFound) {
  CameraParameters given{.width = 640, .height = 480, .fx = 500, .fy = 510, .cx = 320, .cy = 240};
  Pinhole now = to_camera(given, SensorType::rgbd).pinhole;
  EXPECT_EQ(now.row_time, 0);
  EXPECT_EQ(in_use(given, now).readout, 0);
  now.row_time = 4e-5;
  EXPECT_NEAR(in_use(given, now).readout, 0.0192, 1e-12) << "from the first of 480 rows to the last";
  given.readout = -0.03;
  EXPECT_NEAR(to_camera(given, SensorType::stereo).pinhole.row_time, -6.25e-5, 1e-15);
  now.row_time = 0;
  EXPECT_EQ(in_use(given, now).readout, 0) << "a setting says that there is none";
}

TEST(Convert, ACameraComesBack) {
  const CameraParameters given{.width = 640,
                               .height = 480,
                               .fx = 500,
                               .fy = 510,
                               .cx = 320,
                               .cy = 240,
                               .baseline = 0.1,
                               .depth_sigma_a = 0.001,
                               .depth_sigma_b = 0.002,
                               .lens = LensType::kannala_brandt,
                               .distortion = {0.1, 0.2, 0.3, 0.4, 0},
                               .readout = -0.02,
                               .depth_fx = 450,
                               .depth_cx = 322,
                               .depth_x = 0.02};
  const CameraParameters back = to_parameters(to_camera(given, SensorType::rgbd));
  EXPECT_EQ(back.height, given.height);
  EXPECT_EQ(back.fy, given.fy);
  EXPECT_NEAR(back.baseline, given.baseline, 1e-12);
  EXPECT_EQ(back.depth_sigma_b, given.depth_sigma_b);
  EXPECT_EQ(back.lens, given.lens);
  EXPECT_EQ(back.distortion[3], given.distortion[3]);
  EXPECT_NEAR(back.readout, given.readout, 1e-12);
  EXPECT_NEAR(back.depth_fx, given.depth_fx, 1e-12);
  EXPECT_NEAR(back.depth_cx, given.depth_cx, 1e-12);
  EXPECT_NEAR(back.depth_cy, given.cy, 1e-12) << "where none was given";
  EXPECT_NEAR(back.depth_x, given.depth_x, 1e-12);
  EXPECT_EQ(back.depth_y, 0);
  EXPECT_FALSE(to_camera(given, SensorType::monocular).pinhole.registration.any()) << "it measures no depth";
}

TEST(Convert, OnlyAFrameWithAPoseHasItsFigures) {
  FrameReport report;
  TrackResult& track = report.track;
  track.state = TrackingState::lost;
  track.reason = NoPoseReason::few_map_points_agree;
  track.information = Matrix6d::Identity();
  const FrameResult lost = to_result(report);
  EXPECT_EQ(lost.reason, NoPoseReason::few_map_points_agree);
  EXPECT_FALSE(lost.covariance);
  track.state = TrackingState::tracking;
  EXPECT_TRUE(to_result(report).covariance);
  EXPECT_FALSE(to_result(report).dead_reckoned || to_result(report).retracted_from);
  track.method = TrackMethod::dead_reckoned;
  report.retracted_from = 70;
  EXPECT_TRUE(to_result(report).dead_reckoned);
  EXPECT_EQ(to_result(report).retracted_from, 70);
  track.information = Matrix6d::Zero();
  EXPECT_FALSE(to_result(report).covariance) << "nothing is known";
}

// Poses drawn from the information about T_cw scatter, as T_wc, with the covariance that is given for them.
TEST(Convert, TheCovarianceIsThatOfThePoseInTheWorld) {
  Random random(2);
  FrameReport report;
  TrackResult& track = report.track;
  track.state = TrackingState::tracking;
  track.T_cw = random_pose(random);
  Matrix6d root = Matrix6d::Random() * 1e-3 + Matrix6d::Identity() * 2e-3;
  track.information = (root * root.transpose()).inverse();
  const auto covariance = to_result(report).covariance;
  ASSERT_TRUE(covariance);
  const SE3 T_wc = track.T_cw.inverse();
  Matrix6d seen = Matrix6d::Zero();
  constexpr int kDraws = 20000;
  for (int k = 0; k < kDraws; ++k) {
    Vector6d unit;
    for (int i = 0; i < 6; ++i) unit[i] = random.normal();
    const SE3 drawn = (SE3::exp(root * unit) * track.T_cw).inverse();
    Vector6d d;
    d << drawn.t() - T_wc.t(), so3_log(drawn.R() * T_wc.R().transpose());
    seen += d * d.transpose() / kDraws;
  }
  const Matrix6d told = Eigen::Map<const Eigen::Matrix<double, 6, 6, Eigen::RowMajor>>(covariance->data());
  EXPECT_LT((seen - told).norm(), 0.05 * told.norm());
  EXPECT_EQ(told, told.transpose());
}

}  // namespace
}  // namespace covis
