// SPDX-License-Identifier: Apache-2.0
// A painted wall is drawn as both distorted, turned cameras see it; rectified, both images must show it as the two
// ideal cameras would.
#include "covis/io/rectification.h"

#include <gtest/gtest.h>

#include <cmath>

namespace covis::io {
namespace {

constexpr int kColumns = 160, kRows = 120;

Camera make_camera(Distortion distortion, double shift) {
  Camera camera;
  camera.width = kColumns;
  camera.height = kRows;
  camera.pinhole = {100 + shift, 101 - shift, 78 + shift, 61 - shift, 0};
  camera.distortion = distortion;
  if (distortion == Distortion::brown_conrady) camera.coefficients = {-0.25, 0.06, 0.001, -0.0005, 0};
  if (distortion == Distortion::kannala_brandt) camera.coefficients = {-0.02, 0.004, -0.003, 0.001, 0};
  return camera;
}

SE3 make_T_rl() {
  Vector6d turn = Vector6d::Zero();
  turn.tail<3>() << 0.02, -0.03, 0.015;
  return SE3(Eigen::Matrix3d::Identity(), Eigen::Vector3d(-0.2, 0.004, -0.006)) * SE3::exp(turn);
}

// Paint of the wall, which is 3 m before the left camera and slanted; a ray from `from`, all in the left camera.
double paint(const Eigen::Vector3d& from, const Eigen::Vector3d& ray) {
  const Eigen::Vector3d normal = Eigen::Vector3d(0.2, -0.1, 1).normalized();
  const double along = (normal.z() * 3 - normal.dot(from)) / normal.dot(ray);
  const Eigen::Vector3d p = from + along * ray;
  return 128 + 55 * std::sin(5 * p.x()) + 55 * std::sin(4 * p.y() + 1);
}

ImageU8 draw(const Camera& camera, const SE3& T_lc) {
  ImageU8 image(kColumns, kRows);
  for (int y = 0; y < kRows; ++y) {
    for (int x = 0; x < kColumns; ++x) {
      const auto ray = camera.unproject({x, y});
      image(x, y) = ray ? static_cast<uint8_t>(std::lround(paint(T_lc.t(), T_lc.R() * *ray))) : uint8_t{0};
    }
  }
  return image;
}

// Mean and worst difference to what the ideal camera sees, where the lens sees it.
void compare(const ImageU8& image, const Camera& rectified, const Camera& lens, const SE3& T_lens_rectified,
             const SE3& T_l_rectified) {
  double sum = 0, worst = 0;
  int count = 0;
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) {
      const Eigen::Vector3d ray = rectified.pinhole.unproject(x, y);
      const auto pixel = lens.project(T_lens_rectified.R() * ray);
      if (!pixel || pixel->x() < 1 || pixel->y() < 1 || pixel->x() > kColumns - 2 || pixel->y() > kRows - 2) continue;
      const double difference = std::abs(image(x, y) - paint(T_l_rectified.t(), T_l_rectified.R() * ray));
      sum += difference;
      worst = std::max(worst, difference);
      ++count;
    }
  }
  EXPECT_GT(count, kColumns * kRows / 2);
  EXPECT_LT(sum / count, 0.6);
  EXPECT_LT(worst, 4);
}

class RectificationOf : public testing::TestWithParam<Distortion> {};

TEST_P(RectificationOf, BothImagesAreThoseOfIdealCamerasSideBySide) {
  const Camera left = make_camera(GetParam(), 0), right = make_camera(GetParam(), 1.5);
  const SE3 T_rl = make_T_rl();
  const auto rectification = StereoRectification::create(left, right, T_rl);
  ASSERT_TRUE(rectification) << rectification.error().message;
  const Camera& camera = rectification->camera();
  EXPECT_EQ(camera.distortion, Distortion::none);
  EXPECT_NEAR(camera.pinhole.baseline(), T_rl.t().norm(), 1e-12);

  // The right rectified camera is turned like the left one, and a baseline along x from it.
  const SE3 T_l_lr = rectification->T_left_rectified();
  const SE3 T_l_rr = T_l_lr * SE3(Eigen::Matrix3d::Identity(), Eigen::Vector3d(camera.pinhole.baseline(), 0, 0));
  EXPECT_LT(T_l_lr.t().norm(), 1e-12);
  EXPECT_TRUE(T_l_rr.t().isApprox(T_rl.inverse().t(), 1e-9));

  ImageU8 image = draw(left, SE3()), scratch;
  rectification->left(image, scratch);
  compare(image, camera, left, T_l_lr, T_l_lr);
  image = draw(right, T_rl.inverse());
  rectification->right(image, scratch);
  compare(image, camera, right, T_rl * T_l_rr, T_l_rr);
}

INSTANTIATE_TEST_SUITE_P(AllLenses, RectificationOf,
                         testing::Values(Distortion::none, Distortion::brown_conrady, Distortion::kannala_brandt));

TEST(Rectification, RefusesCamerasThatAreNotSideBySide) {
  const Camera camera = make_camera(Distortion::none, 0);
  const auto error = [&](const Camera& right, const Eigen::Vector3d& t) {
    const auto made = StereoRectification::create(camera, right, SE3(Eigen::Matrix3d::Identity(), t));
    return made ? "" : made.error().message;
  };
  EXPECT_NE(error(camera, {0.2, 0, 0}).find("to the right"), std::string::npos) << "swapped";
  EXPECT_NE(error(camera, {0, -0.2, 0}).find("to the right"), std::string::npos) << "one above the other";
  EXPECT_NE(error(camera, {0, 0, 0}).find("to the right"), std::string::npos) << "the same place";
  Camera small = camera;
  small.width = 80;
  EXPECT_NE(error(small, {-0.2, 0, 0}).find("80x120"), std::string::npos);
}

}  // namespace
}  // namespace covis::io
