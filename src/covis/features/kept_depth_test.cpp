// SPDX-License-Identifier: Apache-2.0
#include "covis/features/kept_depth.h"

#include <gtest/gtest.h>

#include <limits>

#include "covis/features/depth_lookup.h"
#include "covis/features/straightening.h"
#include "covis/features/test_features.h"

namespace covis {
namespace {

constexpr int kWide = 161, kHigh = 121;
constexpr Pinhole kSlopeCamera{.fx = 130, .fy = 130, .cx = 80, .cy = 60, .bf = 10};
const Eigen::Vector3d kUnknownTurn = Eigen::Vector3d::Zero();

float slope_depth(int x, int y) { return 1.5f + 0.004f * static_cast<float>(x) + 0.002f * static_cast<float>(y); }

ImageF slope_image() {
  ImageF image(kWide, kHigh);
  for (int y = 0; y < kHigh; ++y)
    for (int x = 0; x < kWide; ++x) image(x, y) = slope_depth(x, y);
  return image;
}

Features keypoints_on_slope() {
  Features f = no_features();
  Random random(1);
  for (int k = 0; k < 200; ++k)
    add(f, {.x = random.uniform(20, kWide - 20), .y = random.uniform(20, kHigh - 20), .level = k % 3, .depth = 9});
  finish(f, {0, 0, kWide, kHigh});
  return f;
}

TEST(KeptDepth, HasWhatTheImageHas) {
  const KeptDepth kept(slope_image().view());
  EXPECT_EQ(kept.width(), kWide);
  for (int y = 0; y < kHigh; y += 6)
    for (int x = 0; x < kWide; x += 4)
      EXPECT_NEAR(1 / kept.inverse_near({x, y}), slope_depth(x, y), 0.0005f * slope_depth(x, y)) << x << ", " << y;
  for (const Eigen::Vector2f& outside :
       {Eigen::Vector2f(-2, 5), Eigen::Vector2f(kWide + 1, 5), Eigen::Vector2f(5, -2), Eigen::Vector2f(5, kHigh + 1),
        Eigen::Vector2f(std::numeric_limits<float>::quiet_NaN(), 5)})
    EXPECT_EQ(kept.inverse_near(outside), 0);
}

TEST(KeptDepth, WhatIsNoDepthStaysNone) {
  ImageF image(8, 8);
  for (int y = 0; y < 8; ++y)
    for (int x = 0; x < 8; ++x) image(x, y) = 0;
  image(2, 2) = std::numeric_limits<float>::infinity();
  image(4, 2) = std::numeric_limits<float>::quiet_NaN();
  image(6, 2) = -1;
  image(2, 4) = 0.05f;  // nearer than any
  image(4, 4) = 30;
  const KeptDepth kept(image.view());
  for (const auto& [x, y] : {std::pair(0, 0), {2, 2}, {4, 2}, {6, 2}, {2, 4}}) EXPECT_EQ(kept.inverse_near({x, y}), 0);
  EXPECT_NEAR(1 / kept.inverse_near({4, 4}), 30, 0.1);
}

TEST(KeptDepth, LooksUpWhereTheRegistrationSays) {
  Features f = keypoints_on_slope();
  Pinhole camera = kSlopeCamera;
  camera.registration = {1.05, 3, -2, 6, 1};
  KeptDepth(slope_image().view()).look_up(camera, f);
  for (size_t i = 0; i < f.x.size(); ++i) {
    const Eigen::Vector2d at =
        camera.registration.pixel(Eigen::Vector2d(f.x[i], f.y[i]), {80, 60}, 1 / static_cast<double>(f.depth[i]));
    EXPECT_NEAR(f.depth[i], 1.5 + 0.004 * at.x() + 0.002 * at.y(), 0.004);
    EXPECT_EQ(f.u_right[i], f.x[i] - 10 / f.depth[i]);
  }
  EXPECT_EQ(f.kept_depth->looked_up_by(), camera.registration);
}

// A depth camera has no part in the lens of the image's camera.
TEST(KeptDepth, LooksUpWithoutTheLensOfTheImage) {
  Features f = keypoints_on_slope();
  auto lens = std::make_shared<Camera>();
  *lens = {.width = kWide, .height = kHigh, .pinhole = kSlopeCamera, .distortion = Distortion::brown_conrady};
  lens->coefficients = {-0.2, 0.03};
  f.raw_x = f.x;
  f.raw_y = f.y;
  f.lens = lens;
  Pinhole camera = kSlopeCamera;
  camera.registration.shift_x = 4;
  KeptDepth(slope_image().view()).look_up(camera, f);
  int measured = 0;
  for (size_t i = 0; i < f.x.size(); ++i) {
    if (!(f.depth[i] > 0)) continue;
    ++measured;
    const Eigen::Vector2d at = lens->undistort({f.raw_x[i], f.raw_y[i]}).value();
    EXPECT_NEAR(f.depth[i], 1.5 + 0.004 * (at.x() + 4) + 0.002 * at.y(), 0.004);
  }
  EXPECT_GT(measured, 150);
}

// As straightening does for key frames whose camera was refined.
TEST(KeptDepth, KeyFramesHaveTheDepthsOfTheirCamera) {
  const Features given = keypoints_on_slope();
  const auto depth = std::make_shared<const KeptDepth>(slope_image().view());
  const auto first = key_frame_features(given, depth, kUnknownTurn, kSlopeCamera);
  EXPECT_EQ(first->depth, given.depth) << "they were looked up so";
  Pinhole other = kSlopeCamera;
  other.registration = {1.05, 3, -2, 0, 0};
  EXPECT_FALSE(straight_for(*first, other));
  const auto second = straightened(*first, other);
  EXPECT_TRUE(straight_for(*second, other));
  EXPECT_EQ(key_frame_features(given, depth, kUnknownTurn, other)->depth, second->depth);
  EXPECT_EQ(second->x, given.x);
  EXPECT_TRUE(second->raw_x.empty()) << "keypoints stay";
  EXPECT_EQ(key_frame_features(given, nullptr, kUnknownTurn, other)->depth, given.depth) << "nothing to look up in";
}

}  // namespace
}  // namespace covis
