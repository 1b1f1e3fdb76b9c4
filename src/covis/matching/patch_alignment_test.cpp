// SPDX-License-Identifier: Apache-2.0
#include "covis/matching/patch_alignment.h"

#include <gtest/gtest.h>

#include <numbers>

#include "covis/features/test_features.h"
#include "covis/features/test_patches.h"

namespace covis {
namespace {

constexpr double kCloseEnough = 0.1;  // pixels

// A view of a texture whose origin is seen at `truth`, and whose keypoint is `off` beside it, in pixels of the patch.
template <class Grey>
PatchView view_of(const Eigen::Vector2d& truth, const Eigen::Vector2d& off, Grey&& grey) {
  const Eigen::Vector2d keypoint = truth + off;
  const Patch patch = test_patch(keypoint, truth, 1, grey);
  return {patch, keypoint.cast<float>() - patch.origin, Eigen::Vector2f::Ones()};
}

Eigen::Vector2d random_step(Random& random, double most) {
  return {random.uniform(-most, most), random.uniform(-most, most)};
}

struct Pair {
  PatchView reference, view;
  Eigen::Matrix2f warp = Eigen::Matrix2f::Identity();
};

// Aligns pairs made of many textures, make(random, texture, off), where `off` is how far the view's keypoint is off.
template <class Make>
void expect_found(uint64_t seed, double least_share, double close_enough, Make&& make) {
  constexpr int kPatches = 200;
  Random random(seed);
  int found = 0, wrong = 0;
  for (int k = 0; k < kPatches; ++k) {
    const Eigen::Vector2d off = random_step(random, 0.5);
    const Pair pair = make(random, TestTexture(static_cast<uint64_t>(k)), off);
    const auto step = align_patch(pair.reference, pair.warp, pair.view);
    if (!step) continue;
    ++found;
    wrong += (step->cast<double>() + off).norm() > close_enough;
  }
  EXPECT_GT(found, kPatches * least_share);
  EXPECT_LE(wrong, kPatches / 100);
}

TEST(PatchAlignment, FindsThePlaceWhateverTheGainAndTheOffset) {
  expect_found(1, 0.9, kCloseEnough, [](Random& random, const TestTexture& texture, const Eigen::Vector2d& off) {
    const double gain = random.uniform(0.6, 1.3), offset = random.uniform(-25, 25);
    const auto other_light = [&](double x, double y) { return gain * (texture(x, y) - 128) + 128 + offset; };
    return Pair{view_of(random_step(random, 0.5) + Eigen::Vector2d(50, 40), {0, 0}, texture),
                view_of(random_step(random, 0.5) + Eigen::Vector2d(80, 90), off, other_light)};
  });
}

TEST(PatchAlignment, FollowsAWarp) {
  expect_found(2, 0.8, 2 * kCloseEnough, [](Random& random, const TestTexture& texture, const Eigen::Vector2d& off) {
    const double angle = random.uniform(-0.4, 0.4), size = random.uniform(0.85, 1.15);
    Eigen::Matrix2d warp;
    warp << std::cos(angle), -std::sin(angle), std::sin(angle), std::cos(angle);
    warp *= size;
    const auto warped = [&](double x, double y) {
      const Eigen::Vector2d there = warp * Eigen::Vector2d(x, y);
      return texture(there.x(), there.y());
    };
    return Pair{view_of({50.2, 40.1}, {0, 0}, texture), view_of({80.4, 90.3}, off, warped), warp.cast<float>()};
  });
}

TEST(PatchAlignment, NothingWhereThereIsNothingToFind) {
  const PatchView reference = view_of({50, 40}, {0, 0}, TestTexture(1));
  const Eigen::Matrix2f same = Eigen::Matrix2f::Identity();
  ASSERT_TRUE(align_patch(reference, same, view_of({50, 40}, {0.2, 0}, TestTexture(1))));
  const PatchView flat = view_of({50, 40}, {0, 0}, [](double, double) { return 90.0; });
  EXPECT_FALSE(align_patch(flat, same, reference));
  EXPECT_FALSE(align_patch(reference, same, flat));
  int alike = 0;
  for (uint64_t seed = 2; seed < 102; ++seed)
    alike += align_patch(reference, same, view_of({50, 40}, {0, 0}, TestTexture(seed))).has_value();
  EXPECT_LE(alike, 2) << "another texture";
  EXPECT_FALSE(align_patch(reference, same, view_of({50, 40}, {2.5, 0}, TestTexture(1)))) << "too far";
}

// The window of a plane that faces the reference camera, point by point.
TEST(PatchAlignment, TheWarpIsThatOfAPlaneThatFacesTheReference) {
  const Pinhole camera{500, 480, 320, 240};
  const Eigen::Vector3d p_r(0.7, -0.4, 4);
  const SE3 T_vr = SE3::exp((Vector6d() << 0.3, 0.1, -0.2, 0.05, -0.08, 0.2).finished());
  const Eigen::Vector2f stretch_r(1.2f, 1.21f), stretch_v(1.44f, 1.43f);
  const auto warp = patch_warp(camera, p_r, T_vr, stretch_r, stretch_v);
  ASSERT_TRUE(warp);
  const Eigen::Vector2d at_r = camera.project(p_r), at_v = camera.project(T_vr * p_r);
  for (const Eigen::Vector2d& step : {Eigen::Vector2d(0.01, 0), Eigen::Vector2d(0, 0.01)}) {
    // Steps in the reference's patch, on the plane through the point across its ray, and where the view sees them.
    const Eigen::Vector2d pixel = at_r + step.cwiseProduct(stretch_r.cast<double>());
    const Eigen::Vector3d ray = camera.unproject(pixel.x(), pixel.y());
    const Eigen::Vector3d on_plane = ray * (p_r.squaredNorm() / p_r.dot(ray));
    const Eigen::Vector2d seen = (camera.project(T_vr * on_plane) - at_v).cwiseQuotient(stretch_v.cast<double>());
    EXPECT_LT((warp->cast<double>() * seen - step).norm(), 1e-4);
  }
}

TEST(PatchAlignment, ViewsThatDifferTooMuchAreNotCompared) {
  const Pinhole camera{500, 500, 320, 240};
  const Eigen::Vector2f one = Eigen::Vector2f::Ones();
  const auto warps = [&](const SE3& T_vr) { return patch_warp(camera, {0, 0, 4}, T_vr, one, one).has_value(); };
  const auto ahead = [](double metres) { return SE3(Eigen::Matrix3d::Identity(), Eigen::Vector3d(0, 0, -metres)); };
  EXPECT_TRUE(warps(ahead(1)));
  EXPECT_FALSE(warps(ahead(2))) << "twice as large";
  EXPECT_FALSE(warps(ahead(-4))) << "half as large";
  EXPECT_FALSE(warps(ahead(5))) << "behind the camera";
  // From the side, 60 degrees of it: one way half as wide.
  const Eigen::Matrix3d R = so3_exp({0, std::numbers::pi / 3, 0});
  EXPECT_FALSE(warps(SE3(R, Eigen::Vector3d(0, 0, 4) - R * Eigen::Vector3d(0, 0, 4))));
}

TEST(PatchAlignment, APlaceMovesInTheImageAndThroughTheLens) {
  Features f = no_features();
  add(f, {.x = 100, .y = 50, .level = 2});
  const Eigen::Vector2f stretch(1.44f, 1.45f), step(0.5f, -0.25f);
  const Eigen::Vector2f by = step.cwiseProduct(stretch);
  auto place = moved_place(f, 0, step, stretch);
  ASSERT_TRUE(place);
  EXPECT_EQ(place->image, Eigen::Vector2f(100, 50) + by);
  EXPECT_EQ(place->undistorted, place->image);

  Camera camera;
  camera.width = 640;
  camera.height = 480;
  camera.pinhole = {500, 500, 320, 240};
  camera.distortion = Distortion::brown_conrady;
  camera.coefficients = {-0.3, 0.1, 0, 0, 0};
  f.lens = std::make_shared<const Camera>(camera);
  f.raw_x = f.x;
  f.raw_y = f.y;
  const Eigen::Vector2d undistorted = camera.undistort({100, 50}).value();
  f.x[0] = static_cast<float>(undistorted.x());
  f.y[0] = static_cast<float>(undistorted.y());
  place = moved_place(f, 0, step, stretch);
  ASSERT_TRUE(place);
  EXPECT_EQ(place->image, Eigen::Vector2f(100, 50) + by);
  EXPECT_LT((place->undistorted.cast<double>() - camera.undistort(place->image.cast<double>()).value()).norm(), 1e-4);
}

}  // namespace
}  // namespace covis
