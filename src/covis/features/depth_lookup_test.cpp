// SPDX-License-Identifier: Apache-2.0
#include "covis/features/depth_lookup.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "covis/core/random.h"

namespace covis {
namespace {

constexpr int kWidth = 80, kHeight = 60;

float depth_of(const ImageF& image, int x, int y, float scale) {
  return depth_at(image.view(), static_cast<float>(x), static_cast<float>(y), scale);
}

template <class Depth>
ImageF make(Depth&& depth) {
  ImageF image(kWidth, kHeight);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) image(x, y) = static_cast<float>(depth(x, y));
  }
  return image;
}

TEST(DepthLookup, WhatNoSurfaceHasIsNoDepth) {
  for (const double depth : {0.0, -1.0, 1e-20, 1e-4, 1e5, 1e13, 1e30, 3.4e38, std::numeric_limits<double>::infinity(),
                             std::numeric_limits<double>::quiet_NaN()}) {
    const ImageF image = make([&](int, int) { return depth; });
    EXPECT_EQ(depth_of(image, 40, 30, 1), 0) << depth;
    EXPECT_EQ(depth_at(image.view(), DepthRegistration{}, {39.5, 29.5}, 40, 30, 1), 0) << depth;
  }
  for (const double depth : {0.01, 5.0, 5000.0})
    EXPECT_FLOAT_EQ(depth_of(make([&](int, int) { return depth; }), 40, 30, 1), static_cast<float>(depth));
}

// Planes of all slants, noise of half a percent.
TEST(DepthLookup, PlanesKeepTheirDepth) {
  Random random(1);
  for (int trial = 0; trial < 50; ++trial) {
    const double at = random.uniform(0.2, 2), along_x = random.uniform(-0.01, 0.01),
                 along_y = random.uniform(-0.01, 0.01);
    const ImageF image = make([&](int x, int y) {
      const double inverse = std::max(0.02, at * (1 + along_x * (x - 40) + along_y * (y - 30)));
      return 1 / inverse * (1 + std::clamp(0.002 * random.normal(), -0.005, 0.005));
    });
    for (const float scale : {1.0f, 1.44f, 3.58f}) {
      for (int y = 0; y < kHeight; ++y) {
        for (int x = 0; x < kWidth; ++x) ASSERT_FLOAT_EQ(depth_of(image, x, y, scale), image(x, y)) << x << ' ' << y;
      }
    }
  }
}

// A board before a wall: on the board depth is the board's, near it there is none, farther off it is the wall's.
TEST(DepthLookup, BesideSomethingNearerThereIsNone) {
  const auto on_board = [](int x, int y) { return x >= 30 && x < 50 && y >= 20 && y < 40; };
  for (const double wall : {1.1, 1.5, 4.0}) {
    const ImageF image = make([&](int x, int y) { return on_board(x, y) ? 1.0 : wall; });
    for (const float scale : {1.0f, 2.0f, 3.58f}) {
      const int reach = static_cast<int>(std::lround(2 * scale));
      for (int y = reach; y < kHeight - reach; ++y) {
        for (int x = reach; x < kWidth - reach; ++x) {
          const int dx = std::max({30 - x, x - 49, 0}), dy = std::max({20 - y, y - 39, 0});
          const float depth = depth_of(image, x, y, scale);
          if (on_board(x, y)) {
            EXPECT_EQ(depth, 1.0f);
          } else if (dx == 0 || dy == 0) {  // beside a side, away from the corners
            EXPECT_EQ(depth, std::max(dx, dy) <= reach ? 0.0f : static_cast<float>(wall)) << x << ' ' << y;
          } else if (std::max(dx, dy) > reach) {
            EXPECT_EQ(depth, static_cast<float>(wall)) << x << ' ' << y;
          }
        }
      }
    }
  }
}

// Missing measurements and the image border give no evidence about their neighbours.
TEST(DepthLookup, HolesAreNoDepthAndNoOutlines) {
  for (const float hole :
       {0.0f, -1.0f, std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    const ImageF image = make([&](int x, int) { return x < 40 ? 2.0f : hole; });
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x)
        EXPECT_EQ(depth_at(image.view(), x, y, 1.2f), x < 40 ? 2.0f : 0.0f) << x << ' ' << hole;
    }
  }
}

// As read from 16 bits by a Kinect-like camera: steps of 1 / 8 pixel of disparity.
TEST(DepthLookup, StepsOfDisparityAreNoOutlines) {
  const double bf = 580 * 0.075;
  for (const double z : {0.8, 2.0, 3.0, 4.5}) {
    Random random(2);
    const ImageF image = make([&](int, int) { return bf / (std::round(8 * bf / z + random.uniform(-0.5, 0.5)) / 8); });
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) EXPECT_GT(depth_at(image.view(), x, y, 1), 0);
    }
  }
}

TEST(DepthLookup, FollowsTheRegistration) {
  const auto plane = [](double x, double y) { return 2 + 0.01 * x + 0.005 * y; };
  const ImageF image = make(plane);
  const DepthRegistration registration{1.1, 4, -3, 5, 2};
  const Eigen::Vector2d centre(38, 31);
  for (const Eigen::Vector2d& at : {Eigen::Vector2d(38, 31), Eigen::Vector2d(20, 40), Eigen::Vector2d(50, 20)}) {
    const float z =
        depth_at(image.view(), registration, centre, static_cast<float>(at.x()), static_cast<float>(at.y()), 1);
    const Eigen::Vector2d there = registration.pixel(at, centre, 1 / static_cast<double>(z));
    EXPECT_NEAR(z, plane(there.x(), there.y()), 0.01);
  }
  EXPECT_EQ(depth_at(image.view(), registration, centre, 79, 30, 1), 0) << "it lies outside of the depth image";
  EXPECT_EQ(depth_at(image.view(), {}, centre, 40, 30, 1), depth_at(image.view(), 40, 30, 1));
}

// A near surface on the one side and a far one on the other each say that the other one is there.
TEST(DepthLookup, NoDepthWhereSurfacesContradictEachOther) {
  const ImageF image = make([](int x, int) { return x < 40 ? 4 : 1; });
  const DepthRegistration parallax{.parallax_x = -20};
  EXPECT_NEAR(depth_at(image.view(), parallax, {40, 30}, 70, 30, 1), 1, 1e-6) << "seen 20 pixels to the left";
  EXPECT_NEAR(depth_at(image.view(), parallax, {40, 30}, 30, 30, 1), 4, 1e-6);
  EXPECT_EQ(depth_at(image.view(), parallax, {40, 30}, 52, 30, 1), 0);
}

}  // namespace
}  // namespace covis
