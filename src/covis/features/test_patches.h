// SPDX-License-Identifier: Apache-2.0
// For tests: patches of textures that are known everywhere.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>

#include "covis/core/random.h"
#include "covis/features/features.h"

namespace covis {

// A smooth texture around the origin, of waves as short as four pixels.
class TestTexture {
 public:
  explicit TestTexture(uint64_t seed) {
    Random random(hash_seed(7, 7, seed));
    for (Wave& wave : waves_) {
      const double length = random.uniform(4, 12), direction = random.uniform(0, 6.28);
      wave = {6.28 / length * std::cos(direction), 6.28 / length * std::sin(direction), random.uniform(0, 6.28)};
    }
  }
  double operator()(double x, double y) const {
    double grey = 128;
    for (const Wave& wave : waves_) grey += 20 * std::sin(wave.x * x + wave.y * y + wave.phase);
    return grey;
  }

 private:
  struct Wave {
    double x = 0, y = 0, phase = 0;
  };
  std::array<Wave, 5> waves_;
};

// The patch of a keypoint at `keypoint` (image pixels) that shows the texture's origin at `origin`. `grey_at(x, y)`:
// the grey level so many of the patch's pixels from there.
template <class Grey>
Patch test_patch(const Eigen::Vector2d& keypoint, const Eigen::Vector2d& origin, double stretch, Grey&& grey_at) {
  Patch patch;
  const Eigen::Vector2d first = (keypoint / stretch).array().round() - Patch::kSide / 2;
  patch.origin = (first * stretch).cast<float>();
  for (int y = 0; y < Patch::kSide; ++y) {
    for (int x = 0; x < Patch::kSide; ++x) {
      const Eigen::Vector2d at = first + Eigen::Vector2d(x, y) - origin / stretch;
      patch.grey[static_cast<size_t>(y * Patch::kSide + x)] =
          static_cast<uint8_t>(std::lround(std::min(255.0, std::max(0.0, grey_at(at.x(), at.y())))));
    }
  }
  return patch;
}

// Gives features patches, as levels of exactly the pyramid's scale would.
inline void start_patches(Features& f) {
  f.patches = std::make_shared<Patches>();
  for (const float scale : f.pyramid->scale) f.patches->stretch.emplace_back(scale, scale);
}

}  // namespace covis
