// SPDX-License-Identifier: Apache-2.0
#include "synth/render/camera_path.h"

#include <gtest/gtest.h>

#include <numbers>

namespace covis::synth {
namespace {

std::vector<CameraPose> square() {
  std::vector<CameraPose> control;
  for (int k = 0; k < 8; ++k) {
    const double a = 2 * std::numbers::pi * k / 8;
    control.push_back({{3 * std::cos(a), 3 * std::sin(a), 1.5}, a});
  }
  return control;
}

TEST(CameraPath, ALoopGoesOnForEver) {
  const CameraPath path(square(), 0.5, 1, {}, 1);
  EXPECT_DOUBLE_EQ(path.period(), 4);
  for (double t = 0; t < 4; t += 0.37) {
    EXPECT_LT((path.at(t).position - path.at(t + 4).position).norm(), 1e-9);
    EXPECT_NEAR(path.at(t + 4).heading - path.at(t).heading, 2 * std::numbers::pi, 1e-9) << "one whole turn";
  }
}

TEST(CameraPath, VelocityDoesNotJump) {
  const CameraPath path(square(), 0.5, 1, {.metres = 0.01, .radians = 0.01}, 1);
  constexpr double kStep = 1e-3;
  Eigen::Vector3d last = (path.at(kStep).position - path.at(0).position) / kStep;
  for (double t = kStep; t < 5; t += kStep) {
    const Eigen::Vector3d velocity = (path.at(t + kStep).position - path.at(t).position) / kStep;
    ASSERT_LT((velocity - last).norm(), 0.02) << t;
    last = velocity;
  }
}

TEST(CameraPath, AnOpenPathEndsAtRest) {
  std::vector<CameraPose> line;
  for (int k = 0; k < 6; ++k) line.push_back({{std::min(k, 4) * 1.0, 0, 1}, 0});
  const CameraPath path(line, 1, {}, 1);
  EXPECT_DOUBLE_EQ(path.period(), 3);
  EXPECT_GT(path.at(1).position.x(), path.at(0).position.x());
  EXPECT_LT((path.at(100).position - path.at(50).position).norm(), 1e-9);
}

TEST(CameraPath, PosesAreOfACameraThatLooksAlongItsHeading) {
  const SE3 T_wc = CameraPose{{1, 2, 3}, std::numbers::pi / 2, 0, 0}.T_wc();
  EXPECT_LT((T_wc * Eigen::Vector3d(0, 0, 1) - Eigen::Vector3d(1, 3, 3)).norm(), 1e-12) << "z is forward";
  EXPECT_LT((T_wc * Eigen::Vector3d(0, 1, 0) - Eigen::Vector3d(1, 2, 2)).norm(), 1e-12) << "y is down";
}

}  // namespace
}  // namespace covis::synth
