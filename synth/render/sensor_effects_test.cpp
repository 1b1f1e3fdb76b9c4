// SPDX-License-Identifier: Apache-2.0
#include "synth/render/sensor_effects.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "synth/test_worlds.h"

namespace covis {
namespace {

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

}  // namespace
}  // namespace covis
