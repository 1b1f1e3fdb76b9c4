// SPDX-License-Identifier: Apache-2.0
#include "covis/features/gradients.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "covis/core/random.h"
#include "covis/core/test_targets.h"
#include "covis/features/extractor.h"
#include "covis/features/test_images.h"

namespace covis {
namespace {

// Bright where both directions from the middle are within the wedge of the given opening, with a soft edge.
ImageU8 wedge(double opening, double turn) {
  constexpr int kSize = 64;
  ImageU8 image(kSize, kSize);
  for (int y = 0; y < kSize; ++y) {
    for (int x = 0; x < kSize; ++x) {
      const double dx = x - kSize / 2, dy = y - kSize / 2;
      const auto beyond = [&](double angle) { return dx * -std::sin(angle) + dy * std::cos(angle); };  // of a line
      const double one = beyond(turn), other = -beyond(turn + opening);
      image(x, y) = static_cast<uint8_t>(std::lround(60 + 140 * std::clamp(std::min(one, other) + 0.5, 0.0, 1.0)));
    }
  }
  return image;
}

GradientSums sums_at(const ImageU8& image, int16_t x, int16_t y) {
  const Corner corner{x, y};
  GradientSums sums;
  gradient_sums(image.view(), &corner, 1, &sums);
  return sums;
}

GradientSums middle_of(const ImageU8& image) { return sums_at(image, 32, 32); }

TEST(Gradients, AnEdgeIsToldFromACornerHoweverItIsTurned) {
  for (int degrees = 0; degrees < 360; degrees += 7) {
    const double turn = degrees * std::numbers::pi / 180;
    EXPECT_TRUE(lies_on_edge(middle_of(wedge(std::numbers::pi, turn)), 18)) << degrees;
    EXPECT_FALSE(lies_on_edge(middle_of(wedge(std::numbers::pi / 2, turn)), 18)) << degrees;
  }
}

TEST(Gradients, SumsAndRatio) {
  ImageU8 image(32, 32);
  for (int y = 0; y < 32; ++y) {
    for (int x = 0; x < 32; ++x) image(x, y) = static_cast<uint8_t>(3 * x + 2 * y);
  }
  const GradientSums sums = sums_at(image, 15, 15);
  EXPECT_EQ(sums, (GradientSums{49 * 36, 49 * 16, 49 * 24}));
  EXPECT_TRUE(lies_on_edge(sums, 1000));
  EXPECT_FALSE(lies_on_edge({500, 100, 0}, 5.01));
  EXPECT_TRUE(lies_on_edge({500, 100, 0}, 4.99));
}

TEST(Gradients, SimdIsTheScalarTwin) {
  Random random(5);
  ImageU8 image = texture(200, 100, 6);
  for (int y = 0; y < 50; ++y) {
    for (int x = 0; x < 200; ++x) image(x, y) = (x / 3 + y / 2) % 2 ? 255 : 0;  // the greatest differences
  }
  for (size_t count = 0; count < 70; ++count) {
    std::vector<Corner> corners(count);
    for (Corner& c : corners) {
      c.x = static_cast<int16_t>(5 + random.below(190));
      c.y = static_cast<int16_t>(5 + random.below(90));
    }
    expect_scalar_twin([&] {
      std::vector<GradientSums> sums(count);
      gradient_sums(image.view(), corners.data(), count, sums.data());
      return sums;
    });
  }
}

TEST(Gradients, CornersOnEdgesAreErasedAndTheOthersKeepTheirOrder) {
  const ImageU8 image = texture(320, 240, 7);
  std::vector<Corner> corners, expected;
  FastDetector().detect(image.view(), 5, 30, 20, 7, corners);
  for (const Corner& c : corners) {
    if (!lies_on_edge(sums_at(image, c.x, c.y), 4)) expected.push_back(c);
  }
  ASSERT_GT(expected.size(), 100u);
  ASSERT_GT(corners.size() - expected.size(), 100u);
  leave_out_edges(image.view(), 4, corners);
  ASSERT_EQ(corners.size(), expected.size());
  for (size_t k = 0; k < corners.size(); ++k) {
    EXPECT_EQ(corners[k].x, expected[k].x);
    EXPECT_EQ(corners[k].y, expected[k].y);
  }
}

// Slanted stripes, and a square among them.
TEST(Gradients, AnExtractorThatLeavesEdgesOutKeepsTheCorners) {
  ImageU8 image(320, 240);
  for (int y = 0; y < 240; ++y) {
    for (int x = 0; x < 320; ++x) {
      const bool in_square = x >= 150 && x < 190 && y >= 100 && y < 140;
      image(x, y) = in_square ? 240 : std::fmod(x + 0.3 * y, 40) < 20 ? 60 : 120;
    }
  }
  OrbExtractor all{OrbOptions{}}, corners(OrbOptions{}, 18);
  EXPECT_GT(all.extract(image.view()).size(), 2 * corners.extract(image.view()).size());
  const KeyPoints& found = corners.keypoints();
  bool at_corner = false;
  for (size_t i = 0; i < found.size(); ++i) at_corner |= std::hypot(found.x[i] - 150, found.y[i] - 100) < 4;
  EXPECT_TRUE(at_corner);
}

}  // namespace
}  // namespace covis
