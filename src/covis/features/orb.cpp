// SPDX-License-Identifier: Apache-2.0
#include "covis/features/orb.h"

#include <array>
#include <cmath>
#include <numbers>

#include "covis/features/orb_pattern.h"

namespace covis {
namespace {

// Half widths of the disc's rows, symmetric about the diagonal.
constexpr std::array<int, kPatchRadius + 1> kHalfWidth = {15, 15, 15, 15, 14, 14, 14, 13, 13, 12, 11, 10, 9, 8, 6, 3};

}  // namespace

float orientation(const uint8_t* pixel, ptrdiff_t stride) {
  int m01 = 0, m10 = 0;
  for (int x = -kPatchRadius; x <= kPatchRadius; ++x) m10 += x * pixel[x];
  for (int y = 1; y <= kPatchRadius; ++y) {
    const uint8_t* below = pixel + y * stride;
    const uint8_t* above = pixel - y * stride;
    const int w = kHalfWidth[static_cast<size_t>(y)];
    int difference = 0;
    for (int x = -w; x <= w; ++x) {
      difference += below[x] - above[x];
      m10 += x * (below[x] + above[x]);
    }
    m01 += y * difference;
  }
  const float angle = std::atan2(static_cast<float>(m01), static_cast<float>(m10));
  return angle < 0 ? angle + 2 * std::numbers::pi_v<float> : angle;
}

Descriptor describe(const uint8_t* pixel, ptrdiff_t stride, float angle) {
  const float c = std::cos(angle), s = std::sin(angle);
  const auto at = [&](float x, float y) {
    const long column = std::lrint(x * c - y * s), row = std::lrint(x * s + y * c);
    return pixel[row * stride + column];
  };
  Descriptor d;
  for (size_t i = 0; i < 256; ++i) {
    const auto& p = kOrbPattern[i];
    if (at(p[0], p[1]) < at(p[2], p[3])) d.bits[i / 64] |= uint64_t{1} << (i % 64);
  }
  return d;
}

}  // namespace covis
