// SPDX-License-Identifier: Apache-2.0
#include "covis/geometry/camera.h"

#include <gtest/gtest.h>

#include <vector>

#include "covis/core/random.h"

namespace covis {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

std::vector<Camera> cameras() {
  Camera pinhole;
  pinhole.width = 640;
  pinhole.height = 480;
  pinhole.pinhole = {525, 520, 319.5, 239.5, 0};
  Camera euroc = pinhole;
  euroc.width = 752;
  euroc.pinhole = {458.654, 457.296, 367.215, 248.375, 0};
  euroc.distortion = Distortion::brown_conrady;
  euroc.coefficients = {-0.28340811, 0.07395907, 0.00019359, 1.76187114e-05, 0};
  Camera freiburg = pinhole;
  freiburg.pinhole = {517.3, 516.5, 318.6, 255.3, 0};
  freiburg.distortion = Distortion::brown_conrady;
  freiburg.coefficients = {0.2624, -0.9531, -0.0054, 0.0026, 1.1633};
  Camera fisheye = pinhole;
  fisheye.width = fisheye.height = 512;
  fisheye.pinhole = {190.978, 190.973, 254.93, 256.90, 0};
  fisheye.distortion = Distortion::kannala_brandt;
  fisheye.coefficients = {0.0034823894, 0.0007150348, -0.0020532361, 0.00020293673, 0};
  return {pinhole, euroc, freiburg, fisheye};
}

TEST(Camera, ProjectUndoesUnproject) {
  for (const Camera& camera : cameras()) {
    int seen = 0;
    for (int y = 0; y < camera.height; y += 16) {
      for (int x = 0; x < camera.width; x += 16) {
        const auto ray = camera.unproject({x, y});
        if (!ray) continue;
        ++seen;
        EXPECT_NEAR(ray->norm(), 1, 1e-12);
        const auto back = camera.project(*ray * 3.7);
        ASSERT_TRUE(back);
        EXPECT_LT((*back - Vector2d(x, y)).norm(), 1e-7);
      }
    }
    EXPECT_GT(seen, 0.95 * (camera.width / 16) * (camera.height / 16));
  }
}

TEST(Camera, JacobiansAgreeWithDifferences) {
  Random random(2);
  for (const Camera& camera : cameras()) {
    for (int trial = 0; trial < 100; ++trial) {
      const Vector3d p(random.uniform(-1, 1), random.uniform(-0.8, 0.8), random.uniform(2, 5));
      Eigen::Matrix<double, 2, 3> J;
      if (!camera.project(p, &J)) continue;
      for (int k = 0; k < 3; ++k) {
        Vector3d step = Vector3d::Zero();
        step(k) = 1e-6;
        const Vector2d difference = (*camera.project(p + step) - *camera.project(p - step)) / 2e-6;
        EXPECT_LT((difference - J.col(k)).norm(), 1e-5 * (1 + J.col(k).norm()));
      }
    }
  }
}

TEST(Camera, BehindOrBeyondTheLensIsNothing) {
  for (const Camera& camera : cameras()) {
    if (camera.distortion != Distortion::kannala_brandt) {
      EXPECT_FALSE(camera.project({0.1, 0.1, -1}));
      EXPECT_FALSE(camera.project({0, 0, 0}));
    }
  }
  Camera folding = cameras()[1];
  folding.coefficients = {-0.3, 0, 0, 0, 0};  // turns back at r = 1.05, where it reaches 0.70
  EXPECT_TRUE(folding.project({0.9, 0, 1}));
  EXPECT_FALSE(folding.project({1.2, 0, 1}));
  EXPECT_FALSE(folding.unproject({367.215 + 0.75 * 458.654, 248.375}));  // no ray ends there
}

TEST(Camera, WhatDiffersIsNamed) {
  const Camera a{640, 480, {500, 500, 320, 240, 40}, Distortion::brown_conrady, {0.1, 0.01, 0, 0, 0}};
  EXPECT_EQ(difference(a, a), "");
  Camera b = a;
  b.pinhole.fx *= 1 + 1e-8;  // the digits of a file
  EXPECT_EQ(difference(a, b), "");
  b.pinhole.fx = b.pinhole.fy = 510;
  b.pinhole.bf = 510 * 0.08;
  EXPECT_EQ(difference(a, b), "fx 510 instead of 500, fy 510 instead of 500");
  b = a;
  b.width = 320;
  b.coefficients[1] = 0.02;
  EXPECT_EQ(difference(a, b), "width 320 instead of 640, lens coefficient 2 0.02 instead of 0.01");
  b = a;
  b.pinhole.bf = 50;
  b.distortion = Distortion::none;
  EXPECT_EQ(difference(a, b), "baseline 0.1 instead of 0.08, another lens");
}

}  // namespace
}  // namespace covis
