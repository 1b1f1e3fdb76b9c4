// SPDX-License-Identifier: Apache-2.0
#include "covis/features/frontend.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "covis/features/test_images.h"

namespace covis {
namespace {

Camera pinhole_camera(double focal, double bf) {
  Camera camera;
  camera.width = 640;
  camera.height = 480;
  camera.pinhole = {focal, focal, 320, 240, bf};
  return camera;
}

// Moved left by a part of a pixel, grey levels mixed linearly; the last column repeats at the right.
ImageU8 moved_left(const ImageU8& image, double shift) {
  ImageU8 moved(image.width(), image.height());
  const int whole = static_cast<int>(shift), last = image.width() - 1;
  const double part = shift - whole;
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x)
      moved(x, y) = static_cast<uint8_t>(std::lround((1 - part) * image(std::min(x + whole, last), y) +
                                                     part * image(std::min(x + whole + 1, last), y)));
  }
  return moved;
}

// The coarsest level is about as small for all.
TEST(Frontend, GreatImagesHaveMoreLevels) {
  const auto levels = [](int width, int height) { return pyramid_levels({}, width, height); };
  EXPECT_EQ(levels(320, 240), 8);
  EXPECT_EQ(levels(640, 480), 8);
  EXPECT_EQ(levels(1241, 376), 8);
  EXPECT_EQ(levels(1024, 575), 8);
  EXPECT_EQ(levels(1024, 576), 9);
  EXPECT_EQ(levels(1280, 720), 10);
  EXPECT_EQ(levels(1080, 1920), 12);
  EXPECT_EQ(levels(3840, 2160), 16);
  EXPECT_EQ(levels(30000, 30000), 16);
  OrbOptions given;
  given.scale_factor = 1.05;
  EXPECT_EQ(pyramid_levels(given, 640, 480), 8);
  given.levels = 5;
  EXPECT_EQ(pyramid_levels(given, 1920, 1080), 5);

  Camera camera = pinhole_camera(500, 0);
  const ImageU8 image = texture(1280, 960, 3);
  camera.width = image.width();
  camera.height = image.height();
  const FeaturesPtr f = Frontend(camera, {}, Sensor::monocular).monocular(image.view());
  EXPECT_EQ(f->pyramid->levels, levels(1280, 960));
  EXPECT_EQ(*std::max_element(f->level.begin(), f->level.end()), f->pyramid->levels - 1);
}

TEST(Frontend, StereoFindsTheDisparity) {
  const ImageU8 left = texture(640, 480, 11);
  for (const double disparity : {6.0, 17.5, 40.25}) {
    Frontend frontend(pinhole_camera(500, 50), {}, Sensor::stereo);
    const FeaturesPtr f = frontend.stereo(left.view(), moved_left(left, disparity).view());
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

TEST(Frontend, PatchesAreTheGreyLevelsAroundKeypoints) {
  const ImageU8 image = texture(640, 480, 12);
  Frontend frontend(pinhole_camera(500, 0), {}, Sensor::monocular);
  const FeaturesPtr f = frontend.monocular(image.view());
  ASSERT_TRUE(f->patches);
  ASSERT_EQ(f->patches->at.size(), f->x.size());
  constexpr int kSide = Patch::kSide;
  for (size_t i = 0; i < f->x.size(); ++i) {
    const Patch& patch = *f->patches->find(i);
    const Eigen::Vector2f at =
        (Eigen::Vector2f(f->x[i], f->y[i]) - patch.origin).cwiseQuotient(f->patches->stretch[f->level[i]]);
    EXPECT_NEAR(at.x(), kSide / 2, 0.501);
    EXPECT_NEAR(at.y(), kSide / 2, 0.501);
    if (f->level[i] > 0) continue;
    const int left = static_cast<int>(std::lround(patch.origin.x())),
              top = static_cast<int>(std::lround(patch.origin.y()));
    for (int y = 0; y < kSide; ++y)
      for (int x = 0; x < kSide; ++x)
        ASSERT_EQ(patch.grey[static_cast<size_t>(y * kSide + x)], image(left + x, top + y));
  }
  OrbOptions without;
  without.patches = false;
  EXPECT_FALSE(Frontend(pinhole_camera(500, 0), without, Sensor::monocular).monocular(image.view())->patches);
}

// A key frame keeps its patches while the frames to come get theirs.
TEST(Frontend, PatchesOfAKeyFrameAreItsOwn) {
  Frontend frontend(pinhole_camera(500, 0), {}, Sensor::monocular);
  const std::shared_ptr<Features> kept = frontend.monocular(texture(640, 480, 13).view())->for_key_frame();
  const std::vector<Patch> before(kept->patches->at.begin(), kept->patches->at.end());
  for (uint64_t seed = 14; seed < 20; ++seed) frontend.monocular(texture(640, 480, seed).view());
  for (size_t i = 0; i < before.size(); ++i) ASSERT_EQ(kept->patches->at[i].grey, before[i].grey);
}

// Two threads share the levels of both images: it must not show.
TEST(Frontend, AnImageOfAPairGivesTheFeaturesItGivesAlone) {
  OrbOptions with_edges;
  with_edges.edge_ratio_mono = 0;
  Frontend pairs(pinhole_camera(500, 50), {}, Sensor::stereo),
      alone(pinhole_camera(500, 50), with_edges, Sensor::monocular);
  for (uint64_t seed = 20; seed < 40; ++seed) {
    const ImageU8 left = texture(640, 480, seed), right = texture(640, 480, seed + 100);
    const FeaturesPtr a = pairs.stereo(left.view(), right.view()), b = alone.monocular(left.view());
    ASSERT_GT(b->size(), 500);
    EXPECT_EQ(a->x, b->x) << seed;
    EXPECT_EQ(a->y, b->y) << seed;
    EXPECT_EQ(a->angle, b->angle) << seed;
    EXPECT_EQ(a->level, b->level) << seed;
    EXPECT_EQ(a->descriptor, b->descriptor) << seed;
  }
}

TEST(Frontend, DepthIsLookedUpAtTheKeyPoint) {
  const ImageU8 image = texture(640, 480, 12);
  ImageF depth(640, 480);
  for (int y = 0; y < 480; ++y) {
    for (int x = 0; x < 640; ++x)
      depth(x, y) = x < 200   ? 0.0f
                    : x < 400 ? std::numeric_limits<float>::quiet_NaN()
                              : 1.0f + static_cast<float>(x) / 640;
  }
  Frontend frontend(pinhole_camera(500, 40), {}, Sensor::rgbd);
  const FeaturesPtr f = frontend.rgbd(image.view(), depth.view());
  int with = 0;
  for (int i = 0; i < f->size(); ++i) {
    const auto k = static_cast<size_t>(i);
    const auto x = static_cast<int>(std::lround(f->image_x()[k]));
    EXPECT_EQ(f->has_depth(i), x >= 400);
    if (!f->has_depth(i)) continue;
    ++with;
    EXPECT_NEAR(f->depth[k], 1.0f + f->image_x()[k] / 640, 1e-3) << "between pixels too";
    EXPECT_NEAR(f->u_right[k], f->x[k] - 40 / f->depth[k], 1e-3);
  }
  EXPECT_GT(with, 100);
  EXPECT_TRUE(f->raw_x.empty() && f->raw_y.empty()) << "without a lens to undo nothing is kept twice";
}

TEST(Frontend, KeyPointsAreUndistorted) {
  Camera camera = pinhole_camera(458, 0);
  camera.distortion = Distortion::brown_conrady;
  camera.coefficients = {-0.28340811, 0.07395907, 0.00019359, 1.76187114e-05, 0};
  Frontend frontend(camera, {}, Sensor::monocular);
  const FeaturesPtr f = frontend.monocular(texture(640, 480, 13).view());
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

// The bounds were those of the border where that is seen at less than a right angle: half of the image, or a line.
TEST(Frontend, AFisheyeLensKeepsWhatItSeesFarOut) {
  const auto greatest_degrees = [](int width, int height, double f) {
    Camera camera = pinhole_camera(f, 0);
    camera.width = width, camera.height = height;
    camera.pinhole = {f, f, width / 2.0, height / 2.0, 0};
    camera.distortion = Distortion::kannala_brandt;
    const FeaturesPtr found = Frontend(camera, {}, Sensor::monocular).monocular(texture(width, height, 14).view());
    double most = 0;
    for (size_t i = 0; i < found->x.size(); ++i) {
      const Eigen::Vector3d ray = camera.pinhole.unproject(found->x[i], found->y[i]);
      most = std::max(most, 57.29578 * std::atan(ray.head<2>().norm()));
    }
    return most;
  };
  EXPECT_GT(greatest_degrees(640, 640, 210), 70) << "87 degrees at the border";
  EXPECT_GT(greatest_degrees(640, 640, 200), 70) << "a circle of 180 degrees within the image";
  EXPECT_GT(greatest_degrees(640, 480, 480 / 3.1415), 70) << "one that touches its top and bottom";
}

}  // namespace
}  // namespace covis
