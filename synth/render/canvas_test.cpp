// SPDX-License-Identifier: Apache-2.0
#include "synth/render/canvas.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

namespace covis::synth {
namespace {

// Sum of the changes from a first tone of 100, in units of square metres times tones.
double painted_area(const Canvas& c) {
  const double sum = std::accumulate(c.pixels().begin(), c.pixels().end(), 0.0);
  const double count = static_cast<double>(c.pixels().size());
  return (sum - 100 * count) * c.width() * c.height() / count;
}

TEST(Canvas, ShapesCoverTheirArea) {
  Canvas c(2, 1, 100, 100);
  c.rect(0.2033, 0.1, 0.7033, 0.4, 200);
  EXPECT_NEAR(painted_area(c), 100 * 0.5 * 0.3, 0.05) << "edges within a pixel are shared";
  Canvas d(2, 1, 100, 100);
  d.disc(1, 0.5, 0.3, 150, 0.5);
  EXPECT_NEAR(painted_area(d), 25 * 3.14159 * 0.09, 0.05);
  Canvas t(2, 1, 100, 100);
  t.triangle({0.1, 1.1, 0.1}, {0.1, 0.1, 0.9}, 200);
  EXPECT_NEAR(painted_area(t), 100 * 0.4, 0.5);
}

TEST(Canvas, SizesAreWholePixelsWithinBounds) {
  const Canvas c(1.005, 0.5, 100, 0);
  EXPECT_EQ(c.columns(), 101);
  EXPECT_EQ(c.rows(), 50);
  EXPECT_EQ(Canvas(1000, 0.001, 100, 0).columns(), 4096);
  EXPECT_EQ(Canvas(1000, 0.001, 100, 0).rows(), 4);
}

TEST(Canvas, NoiseIsOfItsSeedAndWithinItsAmplitude) {
  const auto noisy = [](uint64_t seed) {
    Canvas c(1, 1, 50, 100);
    c.noise(0.1, 0.1, 20, seed);
    return c.pixels();
  };
  const auto [low, high] = std::ranges::minmax(noisy(1));
  EXPECT_GE(low, 80);
  EXPECT_LE(high, 120);
  EXPECT_GT(high - low, 15);
  EXPECT_EQ(noisy(1), noisy(1));
  EXPECT_NE(noisy(1), noisy(2));
}

TEST(Canvas, TextIsAsWideAsItSays) {
  Canvas c(2, 1, 200, 100);
  const double width = c.text(0.1, 0.1, 0.2, "COVIS 7", 0);
  EXPECT_GT(width, 0.4);
  int first = c.columns(), last = 0;
  for (int y = 0; y < c.rows(); ++y) {
    for (int x = 0; x < c.columns(); ++x) {
      if (c.pixels()[static_cast<size_t>(y * c.columns() + x)] > 60) continue;
      first = std::min(first, x);
      last = std::max(last, x);
    }
  }
  EXPECT_GT(first, 18);
  EXPECT_LT(last, (0.1 + width) * 200 + 2);
}

}  // namespace
}  // namespace covis::synth
