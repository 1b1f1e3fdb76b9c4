// SPDX-License-Identifier: Apache-2.0
#include "covis/features/frontend.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "covis/features/test_images.h"

namespace covis {
namespace {

TEST(Frontend, StereoFindsTheDisparity) {
  Camera camera;
  camera.width = 640;
  camera.height = 480;
  camera.pinhole = {500, 500, 320, 240, 50};
  const cv::Mat left = texture(640, 480, 11);
  for (const double disparity : {6.0, 17.5, 40.25}) {
    cv::Mat right;
    const cv::Mat shift = (cv::Mat_<double>(2, 3) << 1, 0, -disparity, 0, 1, 0);
    cv::warpAffine(left, right, shift, left.size(), cv::INTER_CUBIC, cv::BORDER_REPLICATE);
    Frontend frontend(camera, {}, Sensor::stereo);
    const FeaturesPtr f = frontend.stereo(to_image(left).view(), to_image(right).view());
    int matched = 0, wrong = 0;
    for (int i = 0; i < f->size(); ++i) {
      if (!f->has_depth(i)) continue;
      ++matched;
      const auto k = static_cast<size_t>(i);
      wrong += std::abs(f->x[k] - f->u_right[k] - disparity) > 0.5 * f->pyramid->scale[f->level[k]];
      EXPECT_NEAR(f->depth[k], 50 / (f->x[k] - f->u_right[k]), 1e-2 * f->depth[k]);
    }
    EXPECT_GT(matched, f->size() / 3) << disparity;
    EXPECT_LT(wrong, matched / 50) << disparity;
  }
}

TEST(Frontend, StereoByScalarAndSimdIsTheSame) {
  Camera camera;
  camera.width = 333;
  camera.height = 250;
  camera.pinhole = {300, 300, 166, 125, 50};
  const cv::Mat left = texture(333, 250, 14);
  cv::Mat right;
  const cv::Mat shift = (cv::Mat_<double>(2, 3) << 1, 0, -9.3, 0, 1, 0);
  cv::warpAffine(left, right, shift, left.size(), cv::INTER_LINEAR, cv::BORDER_REPLICATE);
  expect_scalar_twin([&] {
    Frontend frontend(camera, {}, Sensor::stereo);
    const FeaturesPtr f = frontend.stereo(to_image(left).view(), to_image(right).view());
    return std::tuple(f->u_right, f->depth, f->descriptor);
  });
}

TEST(Frontend, DepthIsLookedUpAtTheKeyPoint) {
  Camera camera;
  camera.width = 640;
  camera.height = 480;
  camera.pinhole = {500, 500, 320, 240, 40};
  const ImageU8 image = to_image(texture(640, 480, 12));
  ImageF depth(640, 480);
  for (int y = 0; y < 480; ++y) {
    for (int x = 0; x < 640; ++x)
      depth(x, y) = x < 200   ? 0.0f
                    : x < 400 ? std::numeric_limits<float>::quiet_NaN()
                              : 1.0f + static_cast<float>(x) / 640;
  }
  Frontend frontend(camera, {}, Sensor::rgbd);
  const FeaturesPtr f = frontend.rgbd(image.view(), depth.view());
  int with = 0;
  for (int i = 0; i < f->size(); ++i) {
    const auto k = static_cast<size_t>(i);
    const auto x = static_cast<int>(std::lround(f->image_x()[k]));
    EXPECT_EQ(f->has_depth(i), x >= 400);
    if (!f->has_depth(i)) continue;
    ++with;
    EXPECT_FLOAT_EQ(f->depth[k], 1.0f + static_cast<float>(x) / 640);
    EXPECT_NEAR(f->u_right[k], f->x[k] - 40 / f->depth[k], 1e-3);
  }
  EXPECT_GT(with, 100);
  EXPECT_TRUE(f->raw_x.empty() && f->raw_y.empty()) << "without a lens to undo nothing is kept twice";
}

TEST(Frontend, KeyPointsAreUndistorted) {
  Camera camera;
  camera.width = 640;
  camera.height = 480;
  camera.pinhole = {458, 457, 320, 240, 0};
  camera.distortion = Distortion::brown_conrady;
  camera.coefficients = {-0.28340811, 0.07395907, 0.00019359, 1.76187114e-05, 0};
  Frontend frontend(camera, {}, Sensor::monocular);
  const FeaturesPtr f = frontend.monocular(to_image(texture(640, 480, 13)).view());
  ASSERT_GT(f->size(), 500);
  double moved = 0;
  for (size_t i = 0; i < f->x.size(); ++i) {
    const auto back = camera.project(camera.pinhole.unproject(f->x[i], f->y[i]));
    ASSERT_TRUE(back);
    EXPECT_NEAR((*back - Eigen::Vector2d(f->raw_x[i], f->raw_y[i])).norm(), 0, 1e-2);
    EXPECT_TRUE(f->grid.bounds.contains(f->x[i], f->y[i]));
    moved = std::max<double>(moved, std::abs(f->x[i] - f->raw_x[i]));
  }
  EXPECT_GT(moved, 20);
}

}  // namespace
}  // namespace covis
