// SPDX-License-Identifier: Apache-2.0
// For the tests of features: images with corners at every scale.
#pragma once

#include <algorithm>

#include "covis/core/image.h"
#include "covis/core/random.h"
#include "covis/geometry/camera.h"

namespace covis {

// A pinhole camera for images of this size.
inline Camera camera_for(int width, int height) {
  Camera camera{.width = width, .height = height, .pinhole = {}};
  camera.pinhole = {500, 500, 0.5 * (width - 1), 0.5 * (height - 1)};
  return camera;
}

// Draws boxes of many sizes and grey levels, slightly smoothed, with some noise; shifted left by `shift` pixels.
inline ImageU8 texture(int width, int height, uint64_t seed, int shift = 0) {
  Random random(seed);
  Image<float> plain(width, height);
  for (int y = 0; y < height; ++y) std::fill(plain.row(y), plain.row(y) + width, 128.0f);
  for (int k = 0; k < width * height / 300; ++k) {
    const int w = 3 + static_cast<int>(random.below(40)), h = 3 + static_cast<int>(random.below(40));
    const int x0 = static_cast<int>(random.below(static_cast<uint32_t>(width + 60))) - shift,
              y0 = static_cast<int>(random.below(static_cast<uint32_t>(height)));
    const auto grey = static_cast<float>(random.below(256));
    for (int y = y0; y < std::min(height, y0 + h); ++y) {
      for (int x = std::max(0, x0); x < std::min(width, x0 + w); ++x) plain(x, y) = grey;
    }
  }
  ImageU8 image(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const auto at = [&](int dx, int dy) {
        return plain(std::clamp(x + dx, 0, width - 1), std::clamp(y + dy, 0, height - 1));
      };
      const float mean = 0.5f * at(0, 0) + 0.125f * (at(-1, 0) + at(1, 0) + at(0, -1) + at(0, 1));
      image(x, y) = static_cast<uint8_t>(std::clamp(mean + static_cast<float>(random.below(5)), 0.0f, 255.0f));
    }
  }
  return image;
}

}  // namespace covis
