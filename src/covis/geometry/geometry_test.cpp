// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <numbers>

#include "covis/core/random.h"
#include "covis/geometry/alignment.h"
#include "covis/geometry/camera.h"
#include "covis/geometry/pnp.h"
#include "covis/geometry/se3.h"
#include "covis/geometry/triangulation.h"
#include "covis/geometry/two_view.h"

namespace covis {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

Vector3d random_vector(Random& random, double size) {
  return {random.uniform(-size, size), random.uniform(-size, size), random.uniform(-size, size)};
}

double distance(const SE3& a, const SE3& b) { return (a.R() - b.R()).norm() + (a.t() - b.t()).norm(); }

std::vector<Vector6d> tangents() {
  Random random(1);
  std::vector<Vector6d> list{Vector6d::Zero(), Vector6d::Constant(1e-8)};
  for (int k = 0; k < 50; ++k) {
    Vector6d xi;
    const Vector3d axis = random_vector(random, 1).normalized();
    const double angle = k % 5 == 0 ? std::numbers::pi - 1e-7 * k : random.uniform(0, 3.1);
    xi << random_vector(random, 3), angle * axis;
    list.push_back(xi);
  }
  return list;
}

TEST(Se3, GroupLaws) {
  const auto list = tangents();
  for (size_t i = 0; i < list.size(); ++i) {
    const SE3 a = SE3::exp(list[i]), b = SE3::exp(list[(i + 7) % list.size()]),
              c = SE3::exp(list[(i + 13) % list.size()]);
    EXPECT_LT(distance(a * a.inverse(), SE3()), 1e-12);
    EXPECT_LT(distance((a * b) * c, a * (b * c)), 1e-12);
    EXPECT_LT(distance(SE3::exp(a.log()), a), 1e-9);
    EXPECT_LT((SE3::exp(list[i]).log() - list[i]).norm(), 1e-6) << list[i].transpose();
    EXPECT_LT((a.R() * a.R().transpose() - Eigen::Matrix3d::Identity()).norm(), 1e-12);
    EXPECT_LT(((a * b) * Vector3d(1, 2, 3) - a * (b * Vector3d(1, 2, 3))).norm(), 1e-11);
    const Vector6d small = 0.1 * list[(i + 3) % list.size()];
    EXPECT_LT(distance(a * SE3::exp(small), SE3::exp(a.adjoint() * small) * a), 1e-10);
    EXPECT_LT((a * a.centre()).norm(), 1e-12);
  }
}

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

TEST(Triangulation, FindsThePoint) {
  Random random(3);
  for (int trial = 0; trial < 200; ++trial) {
    const Vector3d p(random.uniform(-2, 2), random.uniform(-2, 2), random.uniform(3, 10));
    const SE3 T_1w(so3_exp(random_vector(random, 0.1)), random_vector(random, 0.3));
    const SE3 T_2w(so3_exp(random_vector(random, 0.1)), random_vector(random, 0.3) + Vector3d(1, 0, 0));
    const Vector3d a = T_1w * p, b = T_2w * p;
    const auto found = triangulate(T_1w, a / a.z(), T_2w, b / b.z());
    ASSERT_TRUE(found);
    EXPECT_LT((*found - p).norm(), 1e-8);
  }
}

TEST(Alignment, FindsMotionAndScale) {
  Random random(4);
  for (const bool scaled : {false, true}) {
    std::vector<Vector3d> a, b;
    const SE3 T(so3_exp(random_vector(random, 2)), random_vector(random, 5));
    const double scale = scaled ? 2.5 : 1;
    for (int i = 0; i < 20; ++i) {
      a.push_back(random_vector(random, 3));
      b.push_back(scale * (T.R() * a.back()) + T.t());
    }
    const auto found = align(a, b, scaled);
    ASSERT_TRUE(found);
    EXPECT_LT(distance(found->T_ba, T), 1e-9);
    EXPECT_NEAR(found->scale, scale, 1e-9);
    EXPECT_LT(found->rmse, 1e-9);
    EXPECT_TRUE(found->unique);
  }
  // A mirror image is no rotation: it must not be called one.
  std::vector<Vector3d> a, b;
  for (int i = 0; i < 20; ++i) {
    a.push_back(random_vector(random, 3));
    b.emplace_back(-a.back().x(), a.back().y(), a.back().z());
  }
  EXPECT_NEAR(align(a, b, false)->T_ba.R().determinant(), 1, 1e-9);
  // A straight line can be aligned, not uniquely.
  for (int i = 0; i < 20; ++i)
    b[static_cast<size_t>(i)] = Vector3d(i, 0, 0), a[static_cast<size_t>(i)] = Vector3d(0, i, 0);
  const auto line = align(a, b, false);
  ASSERT_TRUE(line);
  EXPECT_LT(line->rmse, 1e-9);
  EXPECT_FALSE(line->unique);
  EXPECT_FALSE(align(std::vector<Vector3d>(2), std::vector<Vector3d>(2), false));
  EXPECT_FALSE(align(std::vector<Vector3d>(5, Vector3d(1, 1, 1)), b, false));
}

TEST(Pnp, MinimalSolverFindsTheTruth) {
  Random random(5);
  int found = 0;
  for (int trial = 0; trial < 300; ++trial) {
    const SE3 T_cw(so3_exp(random_vector(random, 1.5)), random_vector(random, 2));
    std::array<Vector3d, 3> points, rays;
    for (size_t k = 0; k < 3; ++k) {
      const Vector3d p_c(random.uniform(-2, 2), random.uniform(-2, 2), random.uniform(2, 8));
      points[k] = T_cw.inverse() * p_c;
      rays[k] = p_c / p_c.z();
    }
    std::array<SE3, 4> poses;
    const int count = solve_p3p(points, rays, poses);
    double best = 1e9;
    for (int k = 0; k < count; ++k) best = std::min(best, distance(poses[static_cast<size_t>(k)], T_cw));
    found += best < 1e-4;
  }
  EXPECT_GE(found, 294);
  std::array<SE3, 4> poses;
  EXPECT_EQ(solve_p3p({Vector3d(0, 0, 1), Vector3d(0, 0, 2), Vector3d(0, 0, 3)},
                      {Vector3d(0, 0, 1), Vector3d(0.1, 0, 1), Vector3d(0.2, 0, 1)}, poses),
            0);
}

TEST(Pnp, RansacStandsOutliers) {
  const Pinhole camera{500, 500, 320, 240, 0};
  Random random(6);
  for (int trial = 0; trial < 20; ++trial) {
    const bool planar = trial % 2;
    const SE3 T_cw(so3_exp(random_vector(random, 1)), random_vector(random, 2));
    PnpProblem problem;
    for (int i = 0; i < 100; ++i) {
      const Vector3d p_c(random.uniform(-2, 2), random.uniform(-1.5, 1.5), planar ? 4 : random.uniform(2, 8));
      const bool wrong = i % 2 == 0;
      const Vector2d pixel =
          camera.project(p_c) + (wrong ? Vector2d(random.uniform(-200, 200), random.uniform(-200, 200))
                                       : Vector2d(0.5 * random.normal(), 0.5 * random.normal()));
      problem.add(T_cw.inverse() * p_c, camera.unproject(pixel.x(), pixel.y()), 1);
    }
    const auto result = ransac_pnp(problem, camera, 17);
    ASSERT_TRUE(result);
    EXPECT_GE(result->inliers, 35);
    EXPECT_LT((result->T_cw.centre() - T_cw.centre()).norm(), 0.3);
    EXPECT_EQ(ransac_pnp(problem, camera, 17)->T_cw.t(), result->T_cw.t());
  }
  EXPECT_FALSE(ransac_pnp({}, camera, 1));
}

struct Views {
  TwoViewMatches matches;
  SE3 T_21;
};

enum class Scene { general, planar };

Views make_views(uint64_t seed, Scene scene, const SE3& T_21, double outliers, const Pinhole& camera) {
  Random random(seed);
  Views views{{}, T_21};
  while (views.matches.a.size() < 300) {
    const double x = random.uniform(-2, 2), y = random.uniform(-1.5, 1.5);
    const Vector3d p(x, y, scene == Scene::planar ? 5 + 0.5 * x - 0.3 * y : random.uniform(3, 9));
    const Vector3d q = T_21 * p;
    if (q.z() < 0.5) continue;
    Vector2d a = camera.project(p), b = camera.project(q);
    a += 0.5 * Vector2d(random.normal(), random.normal());
    b += 0.5 * Vector2d(random.normal(), random.normal());
    if (random.uniform() < outliers) b += Vector2d(random.uniform(-60, 60), random.uniform(-60, 60));
    views.matches.a.push_back(a);
    views.matches.b.push_back(b);
  }
  return views;
}

TEST(TwoView, RecoversMotionOrRefuses) {
  const Pinhole camera{500, 500, 320, 240, 0};
  for (const Scene scene : {Scene::general, Scene::planar}) {
    int good = 0, wrong = 0;
    for (uint64_t seed = 1; seed <= 10; ++seed) {
      const SE3 T_21(so3_exp({0.02, -0.08, 0.03}), Vector3d(-0.6, 0.05, 0.1));
      const Views views = make_views(seed, scene, T_21, 0.3, camera);
      const TwoViewResult result = reconstruct_two_views(views.matches, camera, {.seed = seed});
      EXPECT_EQ(result.homography, scene == Scene::planar);
      if (result.status != TwoViewStatus::ok) continue;
      const double rotation = so3_log(result.T_21.R() * T_21.R().transpose()).norm();
      const double direction =
          std::acos(std::clamp(result.T_21.t().normalized().dot(T_21.t().normalized()), -1.0, 1.0));
      ++(rotation < 0.02 && direction < 0.1 ? good : wrong);
    }
    EXPECT_EQ(wrong, 0);
    // Two motions explain a plane seen sideways equally well: no clear winner there.
    if (scene == Scene::general) {
      EXPECT_GE(good, 9);
    }
  }
}

TEST(TwoView, RecoversMotionTowardsAPlane) {
  const Pinhole camera{500, 500, 320, 240, 0};
  int good = 0;
  for (uint64_t seed = 1; seed <= 10; ++seed) {
    const SE3 T_21(so3_exp({0.1, -0.5, 0.03}), Vector3d(2.5, 0.3, 1.2));
    const Views views = make_views(seed, Scene::planar, T_21, 0.1, camera);
    const TwoViewResult result = reconstruct_two_views(views.matches, camera, {.seed = seed});
    if (result.status != TwoViewStatus::ok) continue;
    const double direction = std::acos(std::clamp(result.T_21.t().normalized().dot(T_21.t().normalized()), -1.0, 1.0));
    good += direction < 0.1;
    EXPECT_LT(direction, 0.1);
  }
  EXPECT_GE(good, 1);
}

TEST(TwoView, RefusesWhatTellsNoDepth) {
  const Pinhole camera{500, 500, 320, 240, 0};
  for (uint64_t seed = 1; seed <= 10; ++seed) {
    const SE3 turn(so3_exp({0.02, -0.08, 0.03}), Vector3d::Zero()),
        hardly(so3_exp({0.01, 0.01, 0}), Vector3d(0.01, 0, 0));
    EXPECT_NE(
        reconstruct_two_views(make_views(seed, Scene::general, turn, 0, camera).matches, camera, {.seed = seed}).status,
        TwoViewStatus::ok);
    EXPECT_NE(reconstruct_two_views(make_views(seed, Scene::general, hardly, 0, camera).matches, camera, {.seed = seed})
                  .status,
              TwoViewStatus::ok);
  }
  EXPECT_EQ(reconstruct_two_views({}, camera, {}).status, TwoViewStatus::too_few_matches);
}

// The published fifty points with parallax, among hundreds of far ones, tell the motion badly.
TEST(TwoView, AsksForParallaxOfAQuarterOfThePoints) {
  const Pinhole camera{500, 500, 320, 240, 0};
  const SE3 T_21(so3_exp({0.01, -0.02, 0.01}), Vector3d(-0.15, 0.02, 0.05));
  for (const size_t near : {90, 200}) {
    int refused = 0, begun = 0;
    for (uint64_t seed = 1; seed <= 10; ++seed) {
      Views views = make_views(seed, Scene::general, T_21, 0, camera);
      views.matches.a.resize(near);
      views.matches.b.resize(near);
      Random random(seed);
      while (views.matches.a.size() < 400) {
        const Vector3d p(random.uniform(-40, 40), random.uniform(-30, 30), random.uniform(60, 120));
        views.matches.a.push_back(camera.project(p));
        views.matches.b.push_back(camera.project(T_21 * p));
      }
      const TwoViewStatus status = reconstruct_two_views(views.matches, camera, {.seed = seed}).status;
      refused += status == TwoViewStatus::low_parallax;
      begun += status == TwoViewStatus::ok;
    }
    EXPECT_EQ(refused, near == 90 ? 10 : 0);
    EXPECT_GE(begun, near == 90 ? 0 : 9);
  }
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
