// SPDX-License-Identifier: Apache-2.0
#include "covis/features/orb.h"

#include <array>
#include <cmath>
#include <numbers>

#include "covis/core/simd_targets.h"
#include "covis/features/orb_pattern.h"
#include "covis/features/simd.h"

namespace covis {
namespace {

Moments scalar_moments(const uint8_t* pixel, ptrdiff_t stride) {
  Moments m;
  for (int x = -kPatchRadius; x <= kPatchRadius; ++x) m.x += x * pixel[x];
  for (int y = 1; y <= kPatchRadius; ++y) {
    const uint8_t* below = pixel + y * stride;
    const uint8_t* above = pixel - y * stride;
    const int w = kDiscHalfWidth[static_cast<size_t>(y)];
    int difference = 0;
    for (int x = -w; x <= w; ++x) {
      difference += below[x] - above[x];
      m.x += x * (below[x] + above[x]);
    }
    m.y += y * difference;
  }
  return m;
}

}  // namespace

float orientation(const uint8_t* pixel, ptrdiff_t stride) {
  const Moments m = simd_enabled() ? patch_moments(pixel, stride) : scalar_moments(pixel, stride);
  const float angle = std::atan2(static_cast<float>(m.y), static_cast<float>(m.x));
  return angle < 0 ? angle + 2 * std::numbers::pi_v<float> : angle;
}

namespace {

// The 512 points of the pattern, x and y in separate arrays for SIMD.
struct PatternPoints {
  alignas(64) std::array<float, 512> x, y;
  constexpr PatternPoints() : x(), y() {
    for (size_t i = 0; i < 256; ++i) {
      x[2 * i] = kOrbPattern[i][0];
      y[2 * i] = kOrbPattern[i][1];
      x[2 * i + 1] = kOrbPattern[i][2];
      y[2 * i + 1] = kOrbPattern[i][3];
    }
  }
};
constexpr PatternPoints kPoints;

}  // namespace

TurnedPattern::TurnedPattern(float angle, ptrdiff_t stride) {
  const float c = std::cos(angle), s = std::sin(angle);
  const int pitch = static_cast<int>(stride);
  if (simd_enabled()) {
    turn_points(kPoints.x.data(), kPoints.y.data(), 512, c, s, pitch, offset_.data());
  } else {
    for (size_t i = 0; i < 512; ++i) {
      const float column = std::nearbyint(kPoints.x[i] * c - kPoints.y[i] * s),
                  row = std::nearbyint(kPoints.x[i] * s + kPoints.y[i] * c);
      offset_[i] = static_cast<int32_t>(row) * pitch + static_cast<int32_t>(column);
    }
  }
}

Descriptor TurnedPattern::describe(const uint8_t* pixel) const {
  Descriptor d;
  for (size_t byte = 0; byte < 32; ++byte) {
    // The last bit first: each is shifted in by one place, and the compiler unrolls eight of them.
    uint64_t bits = 0;
    for (size_t k = 16; k > 0; k -= 2) {
      const int32_t* pair = &offset_[16 * byte + k - 2];
      bits = 2 * bits + static_cast<uint64_t>(pixel[pair[0]] < pixel[pair[1]]);
    }
    d.bits[byte / 8] |= bits << byte % 8 * 8;
  }
  return d;
}

Descriptor describe(const uint8_t* pixel, ptrdiff_t stride, float angle) {
  return TurnedPattern(angle, stride).describe(pixel);
}

}  // namespace covis
