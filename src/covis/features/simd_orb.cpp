// SPDX-License-Identifier: Apache-2.0
// Patches: the moments orientation comes from, the turned pattern of the descriptor, sums of differences for stereo.
#include <array>

#include "covis/features/simd.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "covis/features/simd_orb.cpp"
#include <hwy/foreach_target.h>
// after foreach_target
#include <hwy/highway.h>

#include "covis/features/simd-inl.h"

#ifndef COVIS_FEATURES_MOMENT_WEIGHTS
#define COVIS_FEATURES_MOMENT_WEIGHTS
namespace covis {
// For the columns -15 ... 16 in each row of the disc: their x, and the row's y; 0 outside.
struct MomentWeights {
  alignas(64) std::array<std::array<int16_t, 32>, 16> x{}, y{};
  constexpr MomentWeights() {
    for (size_t row = 0; row < 16; ++row) {
      for (int column = -kDiscHalfWidth[row]; column <= kDiscHalfWidth[row]; ++column) {
        x[row][static_cast<size_t>(column + 15)] = static_cast<int16_t>(column);
        y[row][static_cast<size_t>(column + 15)] = static_cast<int16_t>(row);
      }
    }
  }
};
inline constexpr MomentWeights kMomentWeights;
// The 11 columns of a patch.
alignas(16) inline constexpr std::array<uint8_t, 16> kPatchColumns = {255, 255, 255, 255, 255, 255,
                                                                      255, 255, 255, 255, 255};
}  // namespace covis
#endif

HWY_BEFORE_NAMESPACE();
namespace covis::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

Moments PatchMoments(const uint8_t* pixel, ptrdiff_t stride) {
  const hn::CappedTag<int16_t, 16> d;
  const hn::RepartitionToWide<decltype(d)> d32;
  const hn::Rebind<uint8_t, decltype(d)> bytes;
  constexpr size_t kLanes = hn::MaxLanes(d);
  auto mx = hn::Zero(d32), my = hn::Zero(d32);
  for (size_t k = 0; k < 32; k += kLanes) {
    const uint8_t* p = pixel + static_cast<ptrdiff_t>(k) - 15;
    mx = hn::Add(mx, pair_sums(d32, hn::PromoteTo(d, hn::LoadU(bytes, p)), hn::Load(d, &kMomentWeights.x[0][k])));
    for (size_t y = 1; y < 16; ++y) {
      const auto below = hn::PromoteTo(d, hn::LoadU(bytes, p + static_cast<ptrdiff_t>(y) * stride));
      const auto above = hn::PromoteTo(d, hn::LoadU(bytes, p - static_cast<ptrdiff_t>(y) * stride));
      mx = hn::Add(mx, pair_sums(d32, hn::Add(below, above), hn::Load(d, &kMomentWeights.x[y][k])));
      my = hn::Add(my, pair_sums(d32, hn::Sub(below, above), hn::Load(d, &kMomentWeights.y[y][k])));
    }
  }
  return {hn::GetLane(hn::SumOfLanes(d32, mx)), hn::GetLane(hn::SumOfLanes(d32, my))};
}

void TurnPoints(const float* x, const float* y, size_t count, float c, float s, int32_t stride, int32_t* offsets) {
  const hn::CappedTag<float, 16> d;
  const hn::RebindToSigned<decltype(d)> di;
  const auto cosine = hn::Set(d, c), sine = hn::Set(d, s);
  const auto pitch = hn::Set(di, stride);
  for (size_t i = 0; i < count; i += hn::Lanes(d)) {
    const auto px = hn::Load(d, x + i), py = hn::Load(d, y + i);
    // Products rounded each, as in the scalar twin: no fused operations.
    const auto column = hn::ConvertTo(di, hn::Round(hn::Sub(hn::Mul(px, cosine), hn::Mul(py, sine))));
    const auto row = hn::ConvertTo(di, hn::Round(hn::Add(hn::Mul(px, sine), hn::Mul(py, cosine))));
    hn::Store(hn::Add(hn::Mul(row, pitch), column), di, offsets + i);
  }
}

void SlideSad(const uint8_t* a, ptrdiff_t stride_a, const uint8_t* b, ptrdiff_t stride_b, int* sad) {
  const hn::FixedTag<uint8_t, 16> d;
  const hn::FixedTag<uint64_t, 2> d64;
  using Sum = hn::Vec<decltype(d64)>;
  const auto columns = hn::Load(d, kPatchColumns.data());
  Sum sums[11];
  for (Sum& sum : sums) sum = hn::Zero(d64);
  for (int y = 0; y < 11; ++y) {
    const auto pa = hn::LoadU(d, a + y * stride_a);
    const uint8_t* from = b + y * stride_b;
    for (size_t s = 0; s < 11; ++s) {
      const auto pb = hn::LoadU(d, from + s);
      const auto difference = hn::And(hn::Sub(hn::Max(pa, pb), hn::Min(pa, pb)), columns);
      sums[s] = hn::Add(sums[s], hn::SumsOf8(difference));
    }
  }
  for (size_t s = 0; s < 11; ++s) sad[s] = static_cast<int>(hn::GetLane(hn::SumOfLanes(d64, sums[s])));
}

}  // namespace covis::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace covis {
namespace {

HWY_EXPORT(PatchMoments);
HWY_EXPORT(TurnPoints);
HWY_EXPORT(SlideSad);

}  // namespace

Moments patch_moments(const uint8_t* pixel, ptrdiff_t stride) {
  return HWY_DYNAMIC_DISPATCH(PatchMoments)(pixel, stride);
}

void turn_points(const float* x, const float* y, size_t count, float c, float s, int32_t stride, int32_t* offsets) {
  HWY_DYNAMIC_DISPATCH(TurnPoints)(x, y, count, c, s, stride, offsets);
}

void slide_sad(const uint8_t* a, ptrdiff_t stride_a, const uint8_t* b, ptrdiff_t stride_b, int* sad) {
  HWY_DYNAMIC_DISPATCH(SlideSad)(a, stride_a, b, stride_b, sad);
}

}  // namespace covis
#endif
