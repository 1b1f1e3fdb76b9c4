// SPDX-License-Identifier: Apache-2.0
// Image effects of the synthetic camera, and the options.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <hwy/highway.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include "covis/features/extractor.h"
#include "synth/render/renderer.h"
#include "synth/render/scene.h"
#include "synth/test_worlds.h"
#include "synth/worlds/world.h"

namespace covis {
namespace {

using ::testing::HasSubstr;

TEST(Synth, DistortedImagesFollowTheCameraModel) {
  SynthOptions options = small("room", "rgbd");
  options.width = 640;
  options.height = 480;
  Synth straight = make(options);
  options.distortion = 1;
  Synth bent = make(options);
  const Camera& camera = bent.camera();
  ASSERT_EQ(camera.distortion, Distortion::brown_conrady);
  ImageU8 image, bent_image;
  ImageF depth, bent_depth;
  straight.render(20, image, nullptr, &depth);
  bent.render(20, bent_image, nullptr, &bent_depth);
  // Points known from the undistorted frame land where the model says, with their depth and look.
  std::vector<double> tone_errors, depth_errors, unbent_errors;
  double farthest = 0;
  for (int y = 2; y < camera.height - 2; y += 2) {
    for (int x = 2; x < camera.width - 2; x += 2) {
      const Eigen::Vector3d p = static_cast<double>(depth(x, y)) * straight.camera().pinhole.unproject(x, y);
      const auto at = camera.project(p);
      if (!at || !inside(camera, *at)) continue;
      farthest = std::max(farthest, (*at - Eigen::Vector2d(x, y)).norm());
      depth_errors.push_back(std::abs(sample(bent_depth, at->x(), at->y()) - p.z()) / p.z());
      tone_errors.push_back(std::abs(sample(bent_image, at->x(), at->y()) - image(x, y)));
      unbent_errors.push_back(std::abs(static_cast<double>(bent_image(x, y)) - image(x, y)));
    }
  }
  EXPECT_GT(farthest, 30);
  EXPECT_LT(quantile(depth_errors, 0.5), 1e-4);
  EXPECT_LT(quantile(depth_errors, 0.9), 0.01);
  EXPECT_LT(quantile(tone_errors, 0.5), 2.5);
  EXPECT_LT(quantile(tone_errors, 0.5), 0.4 * quantile(unbent_errors, 0.5));
}

double mean(const ImageU8& image) {
  double sum = 0;
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) sum += image(x, y);
  }
  return sum / (image.width() * image.height());
}

TEST(Synth, NoiseHasTheStrengthAskedFor) {
  SynthOptions options = small("desk");
  Synth& clean = world("desk");
  options.noise = 5;
  Synth noisy = make(options);
  ImageU8 a, b;
  clean.render(7, a, nullptr, nullptr);
  noisy.render(7, b, nullptr, nullptr);
  double sum = 0, sum2 = 0;
  int count = 0;
  for (int y = 0; y < a.height(); ++y) {
    for (int x = 0; x < a.width(); ++x) {
      if (std::abs(a(x, y) - 128) > 10) continue;
      const double d = b(x, y) - a(x, y);
      sum += d;
      sum2 += d * d;
      ++count;
    }
  }
  ASSERT_GT(count, 1000);
  EXPECT_NEAR(std::sqrt(sum2 / count), 5, 0.4);
  EXPECT_NEAR(sum / count, 0, 0.4);
}

TEST(Synth, TheStreetsWayCanBeLonger) {
  SynthOptions options = small("street");
  options.way = 500;
  const Synth longer = make(options);
  EXPECT_GT(longer.frames(), 1.3 * world("street").frames());
  double metres = 0;  // once around
  for (int i = 1; i < longer.frames(); ++i) metres += (longer.T_wc(i).t() - longer.T_wc(i - 1).t()).norm();
  EXPECT_NEAR(metres, 500, 50);
  options.world = "room";
  EXPECT_FALSE(Synth::create(options).has_value());
}

TEST(Synth, ExposureChangesOverTimeWithinItsBounds) {
  SynthOptions options = small("room");
  Synth& steady = world("room");
  options.exposure = 0.3;
  Synth lively = make(options);
  ImageU8 a, b;
  double low = 10, high = 0;
  for (int i = 0; i < 600; i += 40) {
    steady.render(i, a, nullptr, nullptr);
    lively.render(i, b, nullptr, nullptr);
    const double gain = mean(b) / mean(a);
    low = std::min(low, gain);
    high = std::max(high, gain);
  }
  EXPECT_GT(low, 0.68);
  EXPECT_LT(high, 1.32);
  EXPECT_GT(high - low, 0.1);
}

TEST(Synth, MotionBlurSmoothsAlongTheMotionOnly) {
  SynthOptions options = small("room");
  Synth& sharp = world("room");
  options.blur = 60;
  Synth blurred = make(options);
  ImageU8 a, b;
  sharp.render(60, a, nullptr, nullptr);
  blurred.render(60, b, nullptr, nullptr);
  // The room's camera mostly turns: things move sideways.
  double across[2] = {}, along[2] = {};
  for (int y = 0; y + 1 < a.height(); ++y) {
    for (int x = 0; x + 1 < a.width(); ++x) {
      along[0] += std::abs(a(x + 1, y) - a(x, y));
      along[1] += std::abs(b(x + 1, y) - b(x, y));
      across[0] += std::abs(a(x, y + 1) - a(x, y));
      across[1] += std::abs(b(x, y + 1) - b(x, y));
    }
  }
  EXPECT_LT(along[1], 0.7 * along[0]);
  EXPECT_GT(across[1] / across[0], along[1] / along[0]);
  EXPECT_NEAR(mean(a), mean(b), 2);
}

TEST(Synth, DepthNoiseIsQuadraticAndLeavesHolesAtEdges) {
  SynthOptions options = small("corridor");
  Synth& exact = world("corridor");
  options.depth_noise = 1;
  Synth sensed = make(options);
  ImageU8 image;
  ImageF a, b;
  double sum2[2] = {}, expected2[2] = {};
  int count[2] = {}, holes = 0, far = 0;
  for (int i = 0; i < 300; i += 50) {
    exact.render(i, image, nullptr, &a);
    sensed.render(i, image, nullptr, &b);
    for (int y = 0; y < a.height(); ++y) {
      for (int x = 0; x < a.width(); ++x) {
        const double z = static_cast<double>(a(x, y)), s = static_cast<double>(b(x, y));
        if (z > 8) {
          EXPECT_EQ(s, 0);
          ++far;
          continue;
        }
        if (s == 0) {
          ++holes;
          continue;
        }
        EXPECT_NEAR(std::round(s * 5000), s * 5000, 0.01);
        const int k = z < 3 ? 0 : 1;
        const double sigma = 0.0012 + 0.0019 * (z - 0.4) * (z - 0.4);
        sum2[k] += (s - z) * (s - z);
        expected2[k] += sigma * sigma;
        ++count[k];
      }
    }
  }
  ASSERT_GT(count[0], 10000);
  ASSERT_GT(count[1], 10000);
  EXPECT_NEAR(std::sqrt(sum2[0] / expected2[0]), 1, 0.05);
  EXPECT_NEAR(std::sqrt(sum2[1] / expected2[1]), 1, 0.05);
  EXPECT_GT(holes, 1000);
  EXPECT_LT(holes, 6 * 320 * 240 / 5);
  EXPECT_GT(far, 100);
}

TEST(Synth, StampsAndDefaults) {
  const Synth room = make(SynthOptions{});
  EXPECT_EQ(room.camera().width, 640);
  EXPECT_EQ(room.camera().height, 480);
  EXPECT_DOUBLE_EQ(room.camera().pinhole.fx, 500);
  EXPECT_DOUBLE_EQ(room.camera().pinhole.cx, 319.5);
  EXPECT_EQ(room.frames(), 600);
  EXPECT_EQ(room.stamp(0), 0);
  EXPECT_EQ(room.stamp(1), 33333000);
  EXPECT_EQ(room.sensor(), Sensor::rgbd);
  EXPECT_NEAR(room.camera().pinhole.baseline(), 0.08, 1e-12);
  EXPECT_EQ(make(small("desk", "mono")).camera().pinhole.bf, 0);
  const Synth street = make(small("street", "stereo"));
  EXPECT_EQ(street.options().fps, 10);
  EXPECT_NEAR(street.camera().pinhole.baseline(), 0.54, 1e-12);
  EXPECT_GT(street.frames(), 380);
  EXPECT_NEAR(world("street").camera().pinhole.baseline(), 0.54, 1e-12);
}

TEST(Synth, SaysWhatIsWrongWithTheOptions) {
  const auto message = [](auto change) {
    SynthOptions options;
    change(options);
    const auto synth = Synth::create(options);
    return synth ? std::string("accepted") : synth.error().message;
  };
  EXPECT_THAT(message([](auto& o) { o.world = "rom"; }), HasSubstr("did you mean 'room'"));
  EXPECT_THAT(message([](auto& o) { o.sensor = "setreo"; }), HasSubstr("did you mean 'stereo'"));
  EXPECT_THAT(message([](auto& o) { o.width = 10; }), HasSubstr("synth.width"));
  EXPECT_THAT(message([](auto& o) { o.noise = -1; }), HasSubstr("synth.noise"));
  EXPECT_THAT(message([](auto& o) { o.noise = std::nan(""); }), HasSubstr("synth.noise"));
  EXPECT_THAT(message([](auto& o) { o.frames = -5; }), HasSubstr("synth.frames"));
  EXPECT_THAT(message([](auto& o) {
                o.sensor = "stereo";
                o.distortion = 1;
              }),
              HasSubstr("rectified"));
}

}  // namespace
}  // namespace covis
