// SPDX-License-Identifier: Apache-2.0
#include "covis/features/unrolling.h"

#include <gtest/gtest.h>

#include <cmath>

#include "covis/features/test_rolling.h"

namespace covis {
namespace {

constexpr Pinhole kSwayed{.fx = 500, .fy = 510, .cx = 320, .cy = 240, .bf = 40};
constexpr double kRowTime = 0.03 / 480;
const Eigen::Vector3d kTurn = Eigen::Vector3d(0.03, -0.05, 0.02) / 480;  // some 2 radians a second in 30 ms

// Keypoints all over the image, every second one with a disparity.
Features all_over() {
  Features f;
  for (int i = 0; i < 400; ++i) {
    f.x.push_back(static_cast<float>(i % 20) * 29 + 40);
    f.y.push_back(static_cast<float>(i / 20) * 24 + 10);
    f.depth.push_back(i % 2 ? 0.0f : 2.0f);
    f.u_right.push_back(i % 2 ? -1.0f : f.x.back() - 60);  // near the left edge it is negative
  }
  f.grid.build({0, 0, 640, 480}, f.x, f.y);
  return f;
}

TEST(Unrolling, PutsKeypointsWhereTheyAreInTheMomentOfTheMiddleRow) {
  const Features truth = all_over();
  Features f = truth;
  roll(kSwayed, kTurn, f);
  const AlignedVector<float> seen_x = f.x, seen_y = f.y;
  double moved = 0;
  for (size_t i = 0; i < f.x.size(); ++i) moved = std::max<double>(moved, std::abs(f.x[i] - truth.x[i]));
  EXPECT_GT(moved, 5) << "pixels";
  unroll(kSwayed, {kTurn / kRowTime, kRowTime}, f);
  EXPECT_EQ(f.exposure.taken(), kTurn);
  EXPECT_EQ(f.image_x(), seen_x) << "they stay where they are in the image";
  EXPECT_EQ(f.image_y(), seen_y);
  for (size_t i = 0; i < f.x.size(); ++i) {
    EXPECT_NEAR(f.x[i], truth.x[i], 0.02);
    EXPECT_NEAR(f.y[i], truth.y[i], 0.02);
    EXPECT_NEAR(f.u_right[i], truth.u_right[i], 0.02);
    EXPECT_TRUE(f.grid.bounds.min_x <= f.x[i] && f.x[i] <= f.grid.bounds.max_x);
    EXPECT_TRUE(f.grid.bounds.min_y <= f.y[i] && f.y[i] <= f.grid.bounds.max_y);
  }
}

TEST(Unrolling, WithoutATurnNothingMoves) {
  const Features truth = all_over();
  Features f = truth;
  unroll(kSwayed, {Eigen::Vector3d::Zero(), kRowTime}, f);
  for (size_t i = 0; i < f.x.size(); ++i) EXPECT_NEAR(f.x[i], truth.x[i], 1e-4);
}

TEST(Unrolling, WhatWasTakenOutIsNotTakenOutAgain) {
  Features once = all_over();
  roll(kSwayed, kTurn, once);
  Features twice = once, back = once;
  const AlignedVector<float> seen_x = once.x;
  unroll(kSwayed, {kTurn / kRowTime, kRowTime}, once);
  unroll(kSwayed, {Eigen::Vector3d(0.5 * kTurn / kRowTime), kRowTime}, twice);
  unroll(kSwayed, {kTurn / kRowTime, kRowTime}, twice);
  unroll(kSwayed, {kTurn / kRowTime, kRowTime}, back);
  unroll(kSwayed, {kTurn / kRowTime, 0}, back);
  for (size_t i = 0; i < once.x.size(); ++i) {
    EXPECT_NEAR(twice.x[i], once.x[i], 0.02);
    EXPECT_NEAR(twice.y[i], once.y[i], 0.02);
    EXPECT_NEAR(back.x[i], seen_x[i], 0.02);
  }
}

TEST(Unrolling, KeypointsOfAWideViewStayInSight) {
  constexpr Pinhole kWide{.fx = 100, .fy = 100, .cx = 320, .cy = 240};  // 146 degrees
  Features f = all_over();
  unroll(kWide, {Eigen::Vector3d(3, 8, 0), 0.1 / 480}, f);
  for (size_t i = 0; i < f.x.size(); ++i) {
    EXPECT_LT(std::abs(f.x[i]), 1e4);
    EXPECT_LT(std::abs(f.y[i]), 1e4);
  }
}

}  // namespace
}  // namespace covis
