// SPDX-License-Identifier: Apache-2.0
#include "covis/features/straightening.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "covis/core/random.h"

namespace covis {
namespace {

constexpr Pinhole kGiven{.fx = 500, .fy = 510, .cx = 322, .cy = 238};

Pinhole with_residual(double focal, double k1, double k2) {
  Pinhole camera = kGiven;
  camera.fx *= focal;
  camera.fy *= focal;
  camera.residual = {k1, k2};
  return camera;
}

Features some_features() {
  Features f;
  Random random(1);
  for (int i = 0; i < 300; ++i) {
    f.x.push_back(static_cast<float>(random.uniform(0, 640)));
    f.y.push_back(static_cast<float>(random.uniform(0, 480)));
    f.depth.push_back(i % 2 == 0 ? 0 : 2);
    f.u_right.push_back(-1);
  }
  f.grid.build({0, 0, 640, 480}, f.x, f.y);
  return f;
}

// Columns of a pair, whose depths follow.
TEST(Straightening, TakesOutWhatRectificationLeft) {
  Pinhole before = kGiven, after = kGiven;
  before.bf = after.bf = 60;
  before.right_columns = {{0.2}};
  after.right_columns = {{0.5, 0.3, 0, 0, 1, -2, 0}};
  Features measured = some_features();
  for (size_t i = 0; i < measured.x.size(); ++i)
    if (measured.depth[i] > 0) measured.u_right[i] = measured.x[i] - static_cast<float>(before.bf) / measured.depth[i];
  EXPECT_FALSE(straight_for(measured, after));
  const auto direct = straightened(measured, after), over = straightened(*straightened(measured, before), after);
  EXPECT_TRUE(straight_for(*direct, after));
  EXPECT_FALSE(straight_for(*direct, kGiven));
  EXPECT_EQ(direct->x, measured.x) << "the left image is as it was";
  for (size_t i = 0; i < measured.x.size(); ++i) {
    EXPECT_EQ(direct->depth[i] > 0, measured.depth[i] > 0);
    if (!(measured.depth[i] > 0)) continue;
    const double expected = after.rectified_column(measured.u_right[i], measured.y[i]);
    EXPECT_NEAR(direct->u_right[i], expected, 1e-3);
    EXPECT_NEAR(direct->depth[i], after.bf / (measured.x[i] - expected), 1e-3);
    EXPECT_NEAR(over->u_right[i], direct->u_right[i], 5e-3);
  }
}

// Their rays are those that Brown's model gives for the pixels of the image.
TEST(Straightening, RaysAreThoseOfTheLens) {
  const Features given = some_features();
  const Pinhole refined = with_residual(1.02, -0.08, 0.03);
  const auto straight = straightened(given, refined);
  EXPECT_TRUE(straight_for(*straight, refined));
  EXPECT_FALSE(straight_for(*straight, kGiven));
  EXPECT_FALSE(straight_for(given, refined));
  Camera lens{.width = 640, .height = 480, .pinhole = refined, .distortion = Distortion::brown_conrady};
  lens.coefficients = {-0.08, 0.03};
  for (size_t i = 0; i < given.x.size(); ++i) {
    const auto undistorted = lens.undistort({given.x[i], given.y[i]});
    ASSERT_TRUE(undistorted);
    EXPECT_NEAR(straight->x[i], undistorted->x(), 1e-3);
    EXPECT_NEAR(straight->y[i], undistorted->y(), 1e-3);
    EXPECT_TRUE(straight->grid.bounds.contains(straight->x[i], straight->y[i]));
  }
  EXPECT_EQ(straight->image_x(), given.x) << "they stay where they are in the image";
}

TEST(Straightening, IsTheSameOnWhateverWay) {
  const Features given = some_features();
  const Pinhole first = with_residual(1, 0.05, -0.02), second = with_residual(0.98, -0.03, 0.01);
  const auto direct = straightened(given, second), over = straightened(*straightened(given, first), second);
  const auto back = straightened(*over, kGiven);
  EXPECT_TRUE(straight_for(*back, kGiven));
  for (size_t i = 0; i < given.x.size(); ++i) {
    EXPECT_NEAR(over->x[i], direct->x[i], 1e-3);
    EXPECT_NEAR(over->y[i], direct->y[i], 1e-3);
    EXPECT_NEAR(back->x[i], given.x[i], 1e-3);
    EXPECT_NEAR(back->y[i], given.y[i], 1e-3);
  }
}

// With no residual distortion the focal length leaves pixels where they are.
TEST(Straightening, WithoutDistortionNothingMoves) {
  const Features given = some_features();
  const Pinhole longer = with_residual(1.1, 0, 0);
  EXPECT_TRUE(straight_for(given, longer));
  EXPECT_EQ(straightened(given, longer)->x, given.x);
}

// A lens that folds its image has no ray far out: keypoints stay there, and the frontend makes none.
TEST(Straightening, WhereNoRayShowsNothingMoves) {
  const Features given = some_features();
  const Pinhole folds = with_residual(1, -1, 0);
  const auto straight = straightened(given, folds);
  int stayed = 0;
  for (size_t i = 0; i < given.x.size(); ++i) {
    const auto at = folds.straightened({given.x[i], given.y[i]});
    stayed += !at;
    EXPECT_NEAR(straight->x[i], at ? at->x() : given.x[i], 1e-3);
  }
  EXPECT_GT(stayed, 10);
  const Camera camera{.width = 640, .height = 480, .pinhole = kGiven};
  EXPECT_TRUE(image_pixel(camera, folds, {0.1, 0, 1}));
  EXPECT_FALSE(image_pixel(camera, folds, {0.7, 0, 1}));
}

TEST(Straightening, NonsenseStaysWithinBounds) {
  Pinhole absurd{.fx = 1e-3, .fy = 1e-3, .residual = {10, 10}};
  const auto straight = straightened(*straightened(some_features(), absurd), kGiven);
  for (const float x : straight->x) EXPECT_LT(std::abs(x), 1e6);
}

TEST(Straightening, ColumnsOfDepthFollow) {
  Pinhole refined = with_residual(1, 0.1, 0);
  refined.bf = 50;
  const auto straight = straightened(some_features(), refined);
  EXPECT_FLOAT_EQ(straight->u_right[1], straight->x[1] - 25);
  EXPECT_EQ(straight->u_right[0], -1);
}

// The rolled image has the lens in it, wherever the turn moved a keypoint to.
TEST(Straightening, TheTurnBetweenRowsAndTheLensAreTakenOutInAnyOrder) {
  const Features given = some_features();
  Pinhole lens = with_residual(1, -0.08, 0.03), shutter = kGiven, both = lens;
  shutter.row_time = both.row_time = 0.02 / 480;
  const Eigen::Vector3d rate(0.4, 1.5, -0.8);
  const auto direct = key_frame_features(given, nullptr, rate, both);
  const auto shutter_first = straightened(*key_frame_features(given, nullptr, rate, shutter), both);
  const auto lens_first = straightened(*key_frame_features(given, nullptr, rate, lens), both);
  EXPECT_TRUE(straight_for(*direct, both));
  EXPECT_FALSE(straight_for(*direct, lens));
  EXPECT_FALSE(straight_for(*direct, shutter));
  EXPECT_EQ(direct->exposure.row_time, both.row_time);
  double moved = 0;
  const auto lens_alone = straightened(given, lens);
  for (size_t i = 0; i < given.x.size(); ++i) {
    EXPECT_NEAR(shutter_first->x[i], direct->x[i], 0.01);
    EXPECT_NEAR(shutter_first->y[i], direct->y[i], 0.01);
    EXPECT_NEAR(lens_first->x[i], direct->x[i], 0.01);
    EXPECT_NEAR(lens_first->y[i], direct->y[i], 0.01);
    moved = std::max<double>(moved, std::abs(direct->x[i] - lens_alone->x[i]));
  }
  EXPECT_GT(moved, 3) << "pixels";
  EXPECT_TRUE(straight_for(*key_frame_features(given, nullptr, Eigen::Vector3d::Zero(), lens), both))
      << "nothing is known of its turn";
}

}  // namespace
}  // namespace covis
