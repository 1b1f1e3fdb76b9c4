// SPDX-License-Identifier: Apache-2.0
#include "covis/features/gradients.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "covis/core/random.h"
#include "covis/features/extractor.h"
#include "covis/features/test_images.h"
#include "covis/features/test_targets.h"

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

GradientSums middle_of(const ImageU8& image) { return gradient_sums(image.row(32) + 32, image.stride()); }

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
  const GradientSums sums = gradient_sums(image.row(15) + 15, image.stride());
  EXPECT_EQ(sums, (GradientSums{49 * 36, 49 * 16, 49 * 24}));
  EXPECT_TRUE(lies_on_edge(sums, 1000));
  EXPECT_FALSE(lies_on_edge({500, 100, 0}, 5.01));
  EXPECT_TRUE(lies_on_edge({500, 100, 0}, 4.99));
}

TEST(Gradients, SimdIsTheScalarTwin) {
  Random random(5);
  const ImageU8 image = texture(200, 100, 6);
  for (int trial = 0; trial < 300; ++trial) {
    const int x = 5 + static_cast<int>(random.below(190)), y = 5 + static_cast<int>(random.below(90));
    expect_scalar_twin([&] { return gradient_sums(image.row(y) + x, image.stride()); });
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
