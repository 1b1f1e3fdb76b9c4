// SPDX-License-Identifier: Apache-2.0
#include "covis/features/gradients.h"

#include <algorithm>
#include <array>

#include "covis/core/simd_targets.h"
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

void gradient_sums(ImageView<const uint8_t> image, const Corner* corners, size_t count, GradientSums* sums) {
  if (simd_enabled()) return patch_gradients(image.data, image.stride, corners, count, sums);
  for (size_t k = 0; k < count; ++k) sums[k] = scalar_gradients(image.row(corners[k].y) + corners[k].x, image.stride);
}

bool lies_on_edge(const GradientSums& sums, double ratio) {
  const double trace = static_cast<double>(sums.xx) + sums.yy;
  const double determinant = static_cast<double>(sums.xx) * sums.yy - static_cast<double>(sums.xy) * sums.xy;
  return determinant * (ratio + 1) * (ratio + 1) < ratio * trace * trace;
}

void leave_out_edges(ImageView<const uint8_t> image, double ratio, std::vector<Corner>& corners) {
  std::array<GradientSums, 64> sums;
  size_t kept = 0;
  for (size_t from = 0; from < corners.size(); from += sums.size()) {
    const size_t count = std::min(sums.size(), corners.size() - from);
    gradient_sums(image, &corners[from], count, sums.data());
    for (size_t k = 0; k < count; ++k) {
      corners[kept] = corners[from + k];
      kept += static_cast<size_t>(!lies_on_edge(sums[k], ratio));  // a branch would be mispredicted often
    }
  }
  corners.resize(kept);
}

}  // namespace covis
