// SPDX-License-Identifier: Apache-2.0
#include "covis/optimization/reduced_blocks.h"

#include "covis/core/simd_targets.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "covis/optimization/reduced_blocks.cpp"
#include <hwy/foreach_target.h>
// after foreach_target
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace covis::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

// Subtracts the rows [first, 6) of a block, as many at once as a vector of D holds. Returns the first row that is left.
template <class D>
HWY_INLINE size_t SubtractRows(D d, size_t first, const double* Y, const double* W, double* block, ptrdiff_t stride) {
  const size_t lanes = hn::Lanes(d);
  for (; first + lanes <= 6; first += lanes) {
    const auto y0 = hn::LoadU(d, Y + first), y1 = hn::LoadU(d, Y + 6 + first), y2 = hn::LoadU(d, Y + 12 + first);
    for (size_t c = 0; c < 6; ++c) {
      auto sum = hn::Mul(y0, hn::Set(d, W[c]));
      sum = hn::Add(hn::Mul(y1, hn::Set(d, W[6 + c])), sum);
      sum = hn::Add(hn::Mul(y2, hn::Set(d, W[12 + c])), sum);
      double* const at = block + static_cast<ptrdiff_t>(c) * stride + first;
      hn::StoreU(hn::Sub(hn::LoadU(d, at), sum), d, at);
    }
  }
  return first;
}

void SubtractPoint(std::span<const PoseOfPoint> poses, double* S, ptrdiff_t stride) {
  for (const PoseOfPoint& i : poses) {
    for (const PoseOfPoint& j : poses) {
      if (j.pose > i.pose) continue;
      double* const block = S + 6 * j.pose * stride + 6 * i.pose;
      size_t row = SubtractRows(hn::CappedTag<double, 4>(), 0, i.Y.data(), j.W->data(), block, stride);
      row = SubtractRows(hn::CappedTag<double, 2>(), row, i.Y.data(), j.W->data(), block, stride);
      SubtractRows(hn::CappedTag<double, 1>(), row, i.Y.data(), j.W->data(), block, stride);
    }
  }
}

}  // namespace covis::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace covis {
namespace {

HWY_EXPORT(SubtractPoint);

}  // namespace

void subtract_point(std::span<const PoseOfPoint> poses, double* S, ptrdiff_t stride) {
  if (simd_enabled()) return HWY_DYNAMIC_DISPATCH(SubtractPoint)(poses, S, stride);
  for (const PoseOfPoint& i : poses) {
    for (const PoseOfPoint& j : poses) {
      if (j.pose > i.pose) continue;
      double* const block = S + 6 * j.pose * stride + 6 * i.pose;
      const double *const Y = i.Y.data(), *const W = j.W->data();
      for (int c = 0; c < 6; ++c) {
        // In this order: Eigen's product would be contracted on some machines.
        for (int r = 0; r < 6; ++r) block[c * stride + r] -= Y[r] * W[c] + Y[6 + r] * W[6 + c] + Y[12 + r] * W[12 + c];
      }
    }
  }
}

}  // namespace covis
#endif
