// SPDX-License-Identifier: Apache-2.0
#include "covis/geometry/two_view.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "covis/core/random.h"

namespace covis {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

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
      const SE3& found = result.motions.at(0).T_21;
      const double rotation = so3_log(found.R() * T_21.R().transpose()).norm();
      const double direction = std::acos(std::clamp(found.t().normalized().dot(T_21.t().normalized()), -1.0, 1.0));
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
    const SE3& found = result.motions.at(0).T_21;
    const double direction = std::acos(std::clamp(found.t().normalized().dot(T_21.t().normalized()), -1.0, 1.0));
    good += direction < 0.1;
    EXPECT_LT(direction, 0.1);
  }
  EXPECT_GE(good, 1);
}

// Two motions explain a plane seen sideways; what stands before it tells them apart.
TEST(TwoView, MatchesOffThePlaneDecide) {
  const Pinhole camera{500, 500, 320, 240, 0};
  const SE3 T_21(so3_exp({0.02, -0.08, 0.03}), Vector3d(-0.6, 0.05, 0.1));
  int open = 0, decided = 0;
  for (uint64_t seed = 1; seed <= 10; ++seed) {
    Views views = make_views(seed, Scene::planar, T_21, 0.1, camera);
    const TwoViewResult plane = reconstruct_two_views(views.matches, camera, {.seed = seed});
    open += plane.status == TwoViewStatus::no_clear_winner && plane.motions.size() > 1;
    Random random(seed);
    for (int i = 0; i < 20; ++i) {
      const Vector3d p(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(2.5, 3.5));
      views.matches.a.push_back(camera.project(p));
      views.matches.b.push_back(camera.project(T_21 * p));
    }
    const TwoViewResult result = reconstruct_two_views(views.matches, camera, {.seed = seed});
    if (result.status != TwoViewStatus::ok) continue;
    ++decided;
    EXPECT_TRUE(result.homography);
    const SE3& found = result.motions.at(0).T_21;
    EXPECT_LT(so3_log(found.R() * T_21.R().transpose()).norm(), 0.03);
    EXPECT_GT(found.t().normalized().dot(T_21.t().normalized()), std::cos(0.15));
  }
  EXPECT_GE(open, 8);
  EXPECT_GE(decided, 8);
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

// Leaves so many points, and adds others at these depths up to 400.
struct FarPoints {
  double nearest, farthest;  // metres
  double noise;              // pixels
};
void add_far_points(size_t left, const FarPoints& far, uint64_t seed, const SE3& T_21, const Pinhole& camera,
                    Views& views) {
  views.matches.a.resize(left);
  views.matches.b.resize(left);
  Random random(seed);
  while (views.matches.a.size() < 400) {
    const double z = random.uniform(far.nearest, far.farthest);
    const Vector3d p(random.uniform(-0.6, 0.6) * z, random.uniform(-0.45, 0.45) * z, z);
    for (const auto& [pixels, seen] : {std::pair(&views.matches.a, p), {&views.matches.b, T_21 * p}})
      pixels->push_back(camera.project(seen) + far.noise * Vector2d(random.normal(), random.normal()));
  }
}

// The published fifty points with parallax, among hundreds of far ones, tell the motion badly.
TEST(TwoView, AsksForParallaxOfAQuarterOfThePoints) {
  const Pinhole camera{500, 500, 320, 240, 0};
  const SE3 T_21(so3_exp({0.01, -0.02, 0.01}), Vector3d(-0.15, 0.02, 0.05));
  for (const size_t near : {90, 200}) {
    int refused = 0, begun = 0;
    for (uint64_t seed = 1; seed <= 10; ++seed) {
      Views views = make_views(seed, Scene::general, T_21, 0, camera);
      add_far_points(near, {60, 120, 0}, seed, T_21, camera, views);
      const TwoViewStatus status = reconstruct_two_views(views.matches, camera, {.seed = seed}).status;
      refused += status == TwoViewStatus::low_parallax;
      begun += status == TwoViewStatus::ok;
    }
    EXPECT_EQ(refused, near == 90 ? 10 : 0);
    EXPECT_GE(begun, near == 90 ? 0 : 9);
  }
}

// Noise puts half of a skyline behind the cameras; a start that refused those as unexplained never came.
TEST(TwoView, BeginsBeforeASkyline) {
  const Pinhole camera{500, 500, 320, 240, 0};
  const SE3 T_21(so3_exp({0.01, -0.02, 0.01}), Vector3d(-0.4, 0.02, 0.05));
  int begun = 0;
  for (uint64_t seed = 1; seed <= 10; ++seed) {
    Views views = make_views(seed, Scene::general, T_21, 0.3, camera);
    add_far_points(200, {1000, 2000, 0.3}, seed, T_21, camera, views);
    const TwoViewResult result = reconstruct_two_views(views.matches, camera, {.seed = seed});
    if (result.status != TwoViewStatus::ok) continue;
    ++begun;
    const TwoViewMotion& found = result.motions.front();
    EXPECT_GT(found.T_21.t().normalized().dot(T_21.t().normalized()), std::cos(0.05)) << seed;
    EXPECT_LE(std::count(found.triangulated.begin(), found.triangulated.end(), 1), 200);
  }
  EXPECT_GE(begun, 9);
}

}  // namespace
}  // namespace covis
