// SPDX-License-Identifier: Apache-2.0
#include "synth/render/loop_path.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace covis::synth {
namespace {

LoopOptions block() {
  LoopOptions o;
  o.length = 60;
  o.width = 40;
  o.corner = 8;
  o.fast = 8;
  o.slow = 4;
  o.easing = 10;
  o.height = 1.6;
  return o;
}

TEST(LoopPath, GoesAroundTheBlockOnce) {
  const CameraPath path = make_loop(block(), 1);
  double metres = 0, farthest_x = 0, farthest_y = 0;
  const int steps = static_cast<int>(path.period() * 50);
  for (int i = 0; i < steps; ++i) {
    const Eigen::Vector3d a = path.at(i * path.period() / steps).position,
                          b = path.at((i + 1) * path.period() / steps).position;
    metres += (b - a).norm();
    farthest_x = std::max(farthest_x, std::abs(a.x()));
    farthest_y = std::max(farthest_y, std::abs(a.y()));
    ASSERT_NEAR(a.z(), 1.6, 1e-9);
  }
  // Straights, and a circle of the corners' radius.
  EXPECT_NEAR(metres, 2 * (60 - 16) + 2 * (40 - 16) + 2 * std::numbers::pi * 8, 3);
  EXPECT_NEAR(farthest_x, 30, 0.5);
  EXPECT_NEAR(farthest_y, 20, 0.5);
  EXPECT_NEAR(path.at(path.period()).heading - path.at(0).heading, 2 * std::numbers::pi, 1e-6);
}

TEST(LoopPath, SlowsDownInCorners) {
  const CameraPath path = make_loop(block(), 1);
  double slowest = 1e9, fastest = 0;
  for (double t = 1; t < path.period() - 1; t += 0.1) {
    const double speed = (path.at(t + 0.05).position - path.at(t - 0.05).position).norm() / 0.1;
    slowest = std::min(slowest, speed);
    fastest = std::max(fastest, speed);
  }
  EXPECT_NEAR(fastest, 8, 0.3);
  EXPECT_NEAR(slowest, 4, 0.5);
}

}  // namespace
}  // namespace covis::synth
