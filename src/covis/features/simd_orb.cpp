// SPDX-License-Identifier: Apache-2.0
// Patches: the moments for the orientation, the rotated pattern of the descriptor, the structure tensor, sums of
// differences for stereo.
#include <array>

#include "covis/features/simd.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "covis/features/simd_orb.cpp"
#include <hwy/foreach_target.h>
// must follow foreach_target
#include <hwy/highway.h>

#include "covis/features/simd-inl.h"

#ifndef COVIS_FEATURES_MOMENT_WEIGHTS
#define COVIS_FEATURES_MOMENT_WEIGHTS
namespace covis {
// For each row of the disc, the columns -15 ... 16: their x, and the row's y; 0 outside the disc.
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
// Selects the 11 columns of a patch out of 16.
alignas(32) inline constexpr std::array<int16_t, 16> kPatchColumns = {1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1};
// Selects the 7 columns of a structure tensor out of 8.
alignas(16) inline constexpr std::array<int16_t, 8> kTensorColumns = {-1, -1, -1, -1, -1, -1, -1};
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

// Eight pixels at `p` and, where a vector holds two corners, eight at `q`, as 16-bit numbers.
template <class D>
HWY_INLINE hn::Vec<D> load_eights(D d, const uint8_t* p, const uint8_t* q) {
  const hn::FixedTag<uint8_t, 8> eight;
  if constexpr (hn::MaxLanes(d) == 16) {
    return hn::PromoteTo(d, hn::Combine(hn::FixedTag<uint8_t, 16>(), hn::LoadU(eight, q), hn::LoadU(eight, p)));
  } else {
    return hn::PromoteTo(d, hn::LoadU(eight, p));
  }
}

void PatchGradients(const uint8_t* image, ptrdiff_t stride, const Corner* corners, size_t count, GradientSums* sums) {
  const hn::CappedTag<int16_t, 16> d;  // eight lanes for a corner
  const hn::RepartitionToWide<decltype(d)> d32;
  const hn::Repartition<int64_t, decltype(d)> d64;
  constexpr size_t kAtOnce = hn::MaxLanes(d) / 8;
  const auto columns = hn::LoadDup128(d, kTensorColumns.data());
  const auto pixel = [&](size_t k) { return image + corners[k].y * stride + corners[k].x - 3; };
  for (size_t k = 0; k < count; k += kAtOnce) {
    const uint8_t* p = pixel(k);
    const uint8_t* q = pixel(k + kAtOnce <= count ? k + kAtOnce - 1 : k);
    const auto row = [&](ptrdiff_t x, ptrdiff_t y) { return load_eights(d, p + y * stride + x, q + y * stride + x); };
    auto xx = hn::Zero(d32), yy = hn::Zero(d32), xy = hn::Zero(d32);
    auto above = row(0, -4), at = row(0, -3);
    for (ptrdiff_t y = -3; y <= 3; ++y) {
      const auto below = row(0, y + 1);
      const auto gx = hn::And(hn::Sub(row(1, y), row(-1, y)), columns);
      const auto gy = hn::And(hn::Sub(below, above), columns);
      xx = hn::Add(xx, pair_sums(d32, gx, gx));
      yy = hn::Add(yy, pair_sums(d32, gy, gy));
      xy = hn::Add(xy, pair_sums(d32, gx, gy));
      above = at;
      at = below;
    }
    // Adds up four lanes into one for xx, yy and xy each.
    const auto halves = [&](auto a, auto b) {
      return hn::BitCast(d64, hn::Add(hn::InterleaveLower(d32, a, b), hn::InterleaveUpper(d32, a, b)));
    };
    const auto squares = halves(xx, yy), products = halves(xy, xy);
    HWY_ALIGN int32_t total[8];
    hn::Store(hn::Add(hn::BitCast(d32, hn::InterleaveLower(d64, squares, products)),
                      hn::BitCast(d32, hn::InterleaveUpper(d64, squares, products))),
              d32, total);
    for (size_t i = 0; i < kAtOnce && k + i < count; ++i)
      sums[k + i] = {total[4 * i], total[4 * i + 1], total[4 * i + 2]};
  }
}

void TurnPoints(const float* x, const float* y, size_t count, float c, float s, int32_t stride, int32_t* offsets) {
  const hn::CappedTag<float, 16> d;
  const hn::RebindToSigned<decltype(d)> di;
  const auto cosine = hn::Set(d, c), sine = hn::Set(d, s);
  const auto pitch = hn::Set(d, static_cast<float>(stride));
  for (size_t i = 0; i < count; i += hn::Lanes(d)) {
    const auto px = hn::Load(d, x + i), py = hn::Load(d, y + i);
    // Each product is rounded on its own, as in the scalar twin: no fused operations. The numbers after that are whole
    // and exact.
    const auto column = hn::Round(hn::Sub(hn::Mul(px, cosine), hn::Mul(py, sine)));
    const auto row = hn::Round(hn::Add(hn::Mul(px, sine), hn::Mul(py, cosine)));
    hn::Store(hn::NearestInt(hn::MulAdd(row, pitch, column)), di, offsets + i);
  }
}

// Eleven rows of an image in quarters of a grey level, and the sums of their columns in grey levels. `kRead` columns
// are read, the others are 0.
template <size_t kRead, size_t kColumns>
struct PatchRows {
  alignas(32) int16_t quarters[11][kColumns];
  alignas(32) int16_t sums[kColumns];

  PatchRows(const uint8_t* from, ptrdiff_t stride) {
    const hn::FixedTag<int16_t, 8> d;
    const hn::Rebind<uint8_t, decltype(d)> bytes;
    for (size_t k = 0; k < kColumns; k += 8) {
      auto sum = hn::Zero(d);
      for (size_t y = 0; y < 11; ++y) {
        auto grey = hn::Zero(d);
        if (k < kRead) grey = hn::PromoteTo(d, hn::LoadU(bytes, from + static_cast<ptrdiff_t>(y) * stride + k));
        sum = hn::Add(sum, grey);
        hn::Store(hn::ShiftLeft<2>(grey), d, &quarters[y][k]);
      }
      hn::Store(sum, d, &sums[k]);
    }
  }
  int sum_of_first() const {
    int sum = 0;
    for (size_t k = 0; k < 11; ++k) sum += sums[k];
    return sum;
  }
};

void SlideSad(const uint8_t* a, ptrdiff_t stride_a, const uint8_t* b, ptrdiff_t stride_b, int* sad) {
  const hn::CappedTag<int16_t, 16> d;
  const hn::RepartitionToWide<decltype(d)> d32;
  const PatchRows<16, 16> patch(a, stride_a);
  const PatchRows<24, 32> strip(b, stride_b);
  const int sum_a = patch.sum_of_first();
  int sum_b = strip.sum_of_first();
  for (size_t s = 0; s < 11; ++s) {
    const auto mean = hn::Set(d, static_cast<int16_t>(quarters_of_mean(sum_b - sum_a)));
    auto sum = hn::Zero(d32);
    for (size_t k = 0; k < 16; k += hn::Lanes(d)) {
      auto columns = hn::Zero(d);  // up to 11 x 2040
      for (size_t y = 0; y < 11; ++y) {
        const auto difference = hn::Sub(hn::Load(d, &patch.quarters[y][k]), hn::LoadU(d, &strip.quarters[y][s + k]));
        columns = hn::Add(columns, hn::Abs(hn::Add(difference, mean)));
      }
      sum = hn::Add(sum, pair_sums(d32, columns, hn::Load(d, &kPatchColumns[k])));
    }
    sad[s] = hn::GetLane(hn::SumOfLanes(d32, sum));
    sum_b += strip.sums[s + 11] - strip.sums[s];
  }
}

}  // namespace covis::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace covis {
namespace {

HWY_EXPORT(PatchMoments);
HWY_EXPORT(PatchGradients);
HWY_EXPORT(TurnPoints);
HWY_EXPORT(SlideSad);

}  // namespace

Moments patch_moments(const uint8_t* pixel, ptrdiff_t stride) {
  return HWY_DYNAMIC_DISPATCH(PatchMoments)(pixel, stride);
}

void patch_gradients(const uint8_t* image, ptrdiff_t stride, const Corner* corners, size_t count, GradientSums* sums) {
  HWY_DYNAMIC_DISPATCH(PatchGradients)(image, stride, corners, count, sums);
}

void turn_points(const float* x, const float* y, size_t count, float c, float s, int32_t stride, int32_t* offsets) {
  HWY_DYNAMIC_DISPATCH(TurnPoints)(x, y, count, c, s, stride, offsets);
}

void slide_sad(const uint8_t* a, ptrdiff_t stride_a, const uint8_t* b, ptrdiff_t stride_b, int* sad) {
  HWY_DYNAMIC_DISPATCH(SlideSad)(a, stride_a, b, stride_b, sad);
}

}  // namespace covis
#endif
