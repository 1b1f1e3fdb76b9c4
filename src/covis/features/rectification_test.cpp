// SPDX-License-Identifier: Apache-2.0
// A painted wall is drawn as both distorted, turned cameras see it; rectified, both images must show it as the two
// ideal cameras would. The resampling by itself must give the bytes that OpenCV's gives.
#include "covis/features/rectification.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "covis/core/random.h"
#include "tests/opencv_images.h"

namespace covis {
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

  ImageU8 image;
  rectification->left(draw(left, SE3()).view(), image);
  compare(image, camera, left, T_l_lr, T_l_lr);
  rectification->right(draw(right, T_rl.inverse()).view(), image);
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
  Camera wide = camera;
  wide.width = 40000;
  const auto made = StereoRectification::create(wide, wide, SE3(Eigen::Matrix3d::Identity(), {-0.2, 0, 0}));
  ASSERT_FALSE(made);
  EXPECT_NE(made.error().message.find("40000x120"), std::string::npos);
}

// There would be no plane that both images could be turned to.
TEST(Rectification, RefusesCamerasThatLookAwayFromEachOther) {
  const Camera camera = make_camera(Distortion::none, 0);
  Eigen::Matrix3d turned = Eigen::Matrix3d::Identity();
  turned(0, 0) = turned(2, 2) = -1;
  const auto made = StereoRectification::create(camera, camera, SE3(turned, {0.2, 0, 0}));
  ASSERT_FALSE(made);
  EXPECT_NE(made.error().message.find("turned by 180 degrees"), std::string::npos) << made.error().message;
}

// A coordinate in an image of `size` pixels: anywhere near it, on a step of 1/32, between two steps, at its ends, or
// far outside.
float random_coordinate(Random& random, int size) {
  const double inside = random.uniform(-3, size + 3);
  switch (random.below(6)) {
    case 0:
      return static_cast<float>(std::floor(inside));
    case 1:
      return static_cast<float>(std::floor(inside * 32) / 32);
    case 2:
      return static_cast<float>(std::floor(inside * 64) / 64);  // half of them are ties
    case 3: {
      const double ends[] = {-1, 0, size - 1.0, static_cast<double>(size)};
      return static_cast<float>(ends[random.below(4)] + (static_cast<double>(random.below(7)) - 3) / 64);
    }
    case 4: {
      constexpr float kMost = std::numeric_limits<float>::max(), kInfinity = std::numeric_limits<float>::infinity();
      const float far[] = {1e4f, 32766.5f, 32767, 32767.99f, 32768, 65536, 67108864, 1e9f, kMost, kInfinity};
      return (random.below(2) ? 1.0f : -1.0f) * far[random.below(std::size(far))];
    }
    default:
      return static_cast<float>(inside);
  }
}

TEST(Resampling, GivesTheBytesOfOpenCv) {
  Random random(7);
  for (int trial = 0; trial < 300; ++trial) {
    const auto size = [&](uint32_t most) { return 1 + static_cast<int>(random.below(most)); };
    const int width = size(90), height = size(40), columns = size(trial % 3 ? 70 : 3), rows = size(trial % 4 ? 50 : 3);
    const int stride = columns + static_cast<int>(random.below(5));
    // Nothing is readable behind the last pixel that a sanitizer would let pass.
    std::vector<uint8_t> bare(static_cast<size_t>(stride * (rows - 1) + columns));
    for (uint8_t& pixel : bare) {
      pixel = static_cast<uint8_t>(random.below(256));
      if (trial % 5 == 0) pixel = 255;                                    // the greatest sums
      if (trial % 5 == 1) pixel = static_cast<uint8_t>(pixel % 2 * 255);  // the greatest differences
    }
    ResamplingMap map(width, height, columns, rows);
    cv::Mat x(height, width, CV_32F), y(height, width, CV_32F);
    for (int v = 0; v < height; ++v) {
      for (int u = 0; u < width; ++u) {
        x.at<float>(v, u) = random_coordinate(random, columns);
        y.at<float>(v, u) = random_coordinate(random, rows);
        map.set(u, v, x.at<float>(v, u), y.at<float>(v, u));
      }
    }
    ImageU8 ours;
    map.apply({bare.data(), columns, rows, stride}, ours);

    const cv::Mat from(rows, columns, CV_8U, bare.data(), static_cast<size_t>(stride));
    cv::Mat fixed, fraction, by_fixed, by_float;
    cv::convertMaps(x, y, fixed, fraction, CV_16SC2);
    cv::remap(from, by_fixed, fixed, fraction, cv::INTER_LINEAR, cv::BORDER_CONSTANT);
    cv::remap(from, by_float, x, y, cv::INTER_LINEAR, cv::BORDER_CONSTANT);
    ASSERT_EQ(cv::norm(as_mat(ours), by_fixed, cv::NORM_INF), 0) << "trial " << trial;
    ASSERT_EQ(cv::norm(as_mat(ours), by_float, cv::NORM_INF), 0) << "trial " << trial;
  }
}

TEST(Resampling, EveryFractionBetweenAnyFourPixelsGivesTheByteOfOpenCv) {
  Random random(8);
  constexpr int kSteps = 32, kTrials = 200;
  ResamplingMap map(kSteps, kSteps, 2, 2);
  cv::Mat x(kSteps, kSteps, CV_32F), y(kSteps, kSteps, CV_32F), expected;
  for (int v = 0; v < kSteps; ++v) {
    for (int u = 0; u < kSteps; ++u) {
      x.at<float>(v, u) = static_cast<float>(u) / kSteps;
      y.at<float>(v, u) = static_cast<float>(v) / kSteps;
      map.set(u, v, x.at<float>(v, u), y.at<float>(v, u));
    }
  }
  ImageU8 image(2, 2), ours;
  for (int trial = 0; trial < kTrials; ++trial) {
    for (int k = 0; k < 4; ++k) image(k % 2, k / 2) = static_cast<uint8_t>(random.below(256));
    map.apply(image.view(), ours);
    cv::remap(as_mat(image), expected, x, y, cv::INTER_LINEAR, cv::BORDER_CONSTANT);
    ASSERT_EQ(cv::norm(as_mat(ours), expected, cv::NORM_INF), 0) << "trial " << trial;
  }
}

TEST(Resampling, WhatHasNoPlaceIsBlack) {
  ImageU8 image(4, 3), made;
  for (int y = 0; y < 3; ++y) std::fill(image.row(y), image.row(y) + 4, uint8_t{200});
  ResamplingMap map(3, 1, 4, 3);
  map.set(1, 0, 2, 1);
  map.set(2, 0, std::numeric_limits<float>::quiet_NaN(), 1);
  map.apply(image.view(), made);
  EXPECT_EQ(made(0, 0), 0) << "never set";
  EXPECT_EQ(made(1, 0), 200);
  EXPECT_EQ(made(2, 0), 0) << "not a number";
}

}  // namespace
}  // namespace covis
