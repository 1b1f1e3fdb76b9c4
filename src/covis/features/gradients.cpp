// SPDX-License-Identifier: Apache-2.0
#include "covis/features/gradients.h"

#include "covis/features/simd.h"

namespace covis {
namespace {

GradientSums scalar_gradients(const uint8_t* pixel, ptrdiff_t stride) {
  constexpr int kRadius = 3;
  GradientSums sums;
  for (int y = -kRadius; y <= kRadius; ++y) {
    const uint8_t* row = pixel + y * stride;
    for (int x = -kRadius; x <= kRadius; ++x) {
      const int gx = row[x + 1] - row[x - 1], gy = row[x + stride] - row[x - stride];
      sums.xx += gx * gx;
      sums.yy += gy * gy;
      sums.xy += gx * gy;
    }
  }
  return sums;
}

}  // namespace

GradientSums gradient_sums(const uint8_t* pixel, ptrdiff_t stride) {
  return simd_enabled() ? patch_gradients(pixel, stride) : scalar_gradients(pixel, stride);
}

bool lies_on_edge(const GradientSums& sums, double ratio) {
  const double trace = static_cast<double>(sums.xx) + sums.yy;
  const double determinant = static_cast<double>(sums.xx) * sums.yy - static_cast<double>(sums.xy) * sums.xy;
  return determinant * (ratio + 1) * (ratio + 1) < ratio * trace * trace;
}

}  // namespace covis
