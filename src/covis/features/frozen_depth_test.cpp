// SPDX-License-Identifier: Apache-2.0
#include "covis/features/frozen_depth.h"

#include <gtest/gtest.h>

#include "covis/core/random.h"

namespace covis {
namespace {

constexpr int kPixels = 128;

// Stripes, moved to the right, with noise.
ImageU8 stripes(int moved, Random& random) {
  ImageU8 image(kPixels, kPixels);
  for (int y = 0; y < kPixels; ++y) {
    for (int x = 0; x < kPixels; ++x)
      image(x, y) = static_cast<uint8_t>(((x + moved) / 20 % 2 ? 60 : 160) + static_cast<int>(random.below(7)));
  }
  return image;
}

ImageF plane(double noise, Random& random, double distance = 2) {
  ImageF depth(kPixels, kPixels);
  for (int y = 0; y < kPixels; ++y) {
    for (int x = 0; x < kPixels; ++x) depth(x, y) = static_cast<float>(distance + noise * random.normal());
  }
  return depth;
}

// The greatest answer of 30 frames.
int most(int pixels_a_frame, double noise, int repeated) {
  Random random(1);
  FrozenDepth frozen;
  ImageF depth;
  int most = 0;
  for (int i = 0; i < 30; ++i) {
    if (i % repeated == 0) depth = plane(noise, random);
    most = std::max(most, frozen.add(stripes(i * pixels_a_frame, random).view(), depth.view()));
  }
  return most;
}

TEST(FrozenDepth, ThatStandsWhileTheCameraMovesIsToldAfterFifteenFrames) {
  EXPECT_EQ(most(1, 0.01, 30), 30);
  EXPECT_GT(most(1, 0.01, 15), 0);
  EXPECT_EQ(most(1, 0.01, 12), 0) << "depth at 5 Hz beside images at 60 Hz";
}

TEST(FrozenDepth, DepthWithNoiseOrOfAStandingCameraIsNot) {
  EXPECT_EQ(most(1, 0.01, 1), 0);
  EXPECT_EQ(most(0, 0.01, 1), 0);
  EXPECT_EQ(most(0, 0, 1), 0) << "exact depth of a camera that stands";
}

TEST(FrozenDepth, NoDepthIsNot) {
  Random random(1);
  FrozenDepth frozen;
  const ImageF none = plane(0, random, 0);
  for (int i = 0; i < 30; ++i) EXPECT_EQ(frozen.add(stripes(i, random).view(), none.view()), 0);
}

}  // namespace
}  // namespace covis
