// SPDX-License-Identifier: Apache-2.0
// Rows of the pyramid and of the blur. All sums are of whole numbers and exact, so that order does not matter.
#include <array>

#include "covis/features/simd.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "covis/features/simd_pyramid.cpp"
#include <hwy/foreach_target.h>
// after foreach_target
#include <hwy/highway.h>

#include "covis/features/simd-inl.h"

HWY_BEFORE_NAMESPACE();
namespace covis::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

// Eight pixels of 16 lanes, or in two steps of 8.
template <class D16>
HWY_INLINE void mix_group(D16 d16, const uint8_t* row, const ResizeGroup& group, int32_t* out) {
  const hn::FixedTag<uint8_t, 16> bytes;
  const hn::RepartitionToWide<D16> d32;
  const auto pairs = hn::TableLookupBytes(hn::LoadU(bytes, row + group.base), hn::Load(bytes, group.pick.data()));
  const auto mix = [&](auto part, size_t at) {
    hn::StoreU(pair_sums(d32, hn::PromoteTo(d16, part), hn::LoadU(d16, group.weight.data() + at)), d32, out + at / 2);
  };
  if constexpr (hn::MaxLanes(D16()) == 16) {
    mix(pairs, 0);
  } else {
    const hn::Half<decltype(bytes)> half;
    mix(hn::LowerHalf(half, pairs), 0);
    mix(hn::UpperHalf(half, pairs), 8);
  }
}

void ResizeColumns(const uint8_t* row, const ResizeGroup* groups, size_t count, uint32_t* out) {
  for (size_t g = 0; g < count; ++g)
    mix_group(hn::CappedTag<int16_t, 16>(), row, groups[g], reinterpret_cast<int32_t*>(out + 8 * g));
}

void ResizeRows(const uint32_t* above, const uint32_t* below, uint32_t weight, int width, uint8_t* out) {
  const hn::CappedTag<uint32_t, 16> d;
  const hn::RebindToSigned<decltype(d)> di;
  const hn::Rebind<uint8_t, decltype(d)> bytes;
  const auto step = static_cast<int>(hn::Lanes(d));
  const auto w = hn::Set(d, weight), half = hn::Set(d, 1u << (2 * kResizeBits - 1));
  for (int x = 0; x < width; x += step) {
    if (x + step > width) x = width - step;  // some pixels twice rather than beyond the row
    const auto a = hn::LoadU(d, above + x), b = hn::LoadU(d, below + x);
    // a (2^11 - w) + b w, modulo 2^32
    const auto sum = hn::Add(hn::Add(hn::ShiftLeft<kResizeBits>(a), hn::Mul(hn::Sub(b, a), w)), half);
    hn::StoreU(hn::DemoteTo(bytes, hn::BitCast(di, hn::ShiftRight<2 * kResizeBits>(sum))), bytes, out + x);
  }
}

void BlurRow(const uint8_t* const* rows, int width, int16_t* line, uint8_t* out) {
  const hn::CappedTag<uint16_t, 32> d;
  const hn::RebindToSigned<decltype(d)> di;
  const hn::RepartitionToWide<decltype(di)> d32;
  const hn::RepartitionToWide<decltype(d)> du32;
  const hn::Rebind<uint8_t, decltype(d)> bytes;
  const auto step = static_cast<int>(hn::Lanes(d));
  {
    // Down the columns: up to 65280, kept 32768 lower to fit a signed number.
    const auto w0 = hn::Set(d, kGauss[0]), w1 = hn::Set(d, kGauss[1]), w2 = hn::Set(d, kGauss[2]),
               w3 = hn::Set(d, kGauss[3]);
    const auto sign = hn::Set(d, 0x8000);
    for (int x = 0; x < width; x += step) {
      if (x + step > width) x = width - step;
      const auto at = [&](size_t k) { return hn::PromoteTo(d, hn::LoadU(bytes, rows[k] + x)); };
      const auto outer = hn::Add(hn::Mul(hn::Add(at(0), at(6)), w0), hn::Mul(hn::Add(at(1), at(5)), w1));
      const auto inner = hn::Add(hn::Mul(hn::Add(at(2), at(4)), w2), hn::Mul(at(3), w3));
      hn::StoreU(hn::BitCast(di, hn::Xor(hn::Add(outer, inner), sign)), di, line + x);
    }
  }
  for (int k = 1; k <= 3; ++k) {
    line[-k] = line[k];
    line[width - 1 + k] = line[width - 1 - k];
  }
  // Along the row by pairs of neighbours, even and odd pixels apart: each weighs eight from its first on, the last with
  // 0.
  hn::Vec<decltype(di)> w[4];
  for (size_t k = 0; k < 4; ++k) {
    const uint32_t first = kGauss[2 * k], second = k == 3 ? 0 : kGauss[2 * k + 1];
    w[k] = hn::BitCast(di, hn::Set(du32, first | second << 16));
  }
  const auto bias = hn::Set(d32, 256 * 32768 + 32768);  // restores the lowering, and adds a half for rounding
  for (int x = 0; x < width; x += step) {
    if (x + step > width) x = width - step;
    const auto sums = [&](const int16_t* p) {
      const auto a = hn::Add(pair_sums(d32, hn::LoadU(di, p), w[0]), pair_sums(d32, hn::LoadU(di, p + 2), w[1]));
      const auto b = hn::Add(pair_sums(d32, hn::LoadU(di, p + 4), w[2]), pair_sums(d32, hn::LoadU(di, p + 6), w[3]));
      return hn::BitCast(du32, hn::Add(hn::Add(a, b), bias));
    };
    const auto even = hn::ShiftRight<16>(sums(line + x - 3));
    const auto odd = hn::And(sums(line + x - 2), hn::Set(du32, 0xFFFF0000u));
    hn::StoreU(hn::DemoteTo(bytes, hn::BitCast(di, hn::Or(even, odd))), bytes, out + x);
  }
}

}  // namespace covis::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace covis {
namespace {

HWY_EXPORT(ResizeColumns);
HWY_EXPORT(ResizeRows);
HWY_EXPORT(BlurRow);

}  // namespace

void resize_columns(const uint8_t* row, const ResizeGroup* groups, size_t count, uint32_t* out) {
  HWY_DYNAMIC_DISPATCH(ResizeColumns)(row, groups, count, out);
}

void resize_rows(const uint32_t* above, const uint32_t* below, uint32_t weight, int width, uint8_t* out) {
  HWY_DYNAMIC_DISPATCH(ResizeRows)(above, below, weight, width, out);
}

void blur_row(const uint8_t* const* rows, int width, int16_t* line, uint8_t* out) {
  HWY_DYNAMIC_DISPATCH(BlurRow)(rows, width, line, out);
}

}  // namespace covis
#endif
