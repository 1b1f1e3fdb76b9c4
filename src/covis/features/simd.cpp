// SPDX-License-Identifier: Apache-2.0
#include "covis/features/simd.h"

#include <array>

#include "covis/core/simd_targets.h"
#include "covis/features/fast.h"
#include "covis/features/hamming.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "covis/features/simd.cpp"
#include <hwy/foreach_target.h>
// must follow foreach_target
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace covis::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

// Takes the sixteen differences to the circle, all with the same sign, and returns the greatest minimum of nine
// contiguous ones, by doubling: runs of 2, 4 and 8. Each run of 8 serves two of 9, with the one before it and with the
// one after it. Uses plain arrays because std::array's functions are not compiled for this section's instruction set,
// and vectors cannot be created in them.
template <class V>
HWY_INLINE V best_run(const V* d) {
  V two[8], four[8];  // the minima of the runs that begin at 2 k + 1
  for (size_t k = 0; k < 8; ++k) two[k] = hn::Min(d[2 * k + 1], d[(2 * k + 2) % 16]);
  for (size_t k = 0; k < 8; ++k) four[k] = hn::Min(two[k], two[(k + 1) % 8]);
  const auto nine = [&](size_t k) {
    return hn::Min(hn::Min(four[k], four[(k + 2) % 8]), hn::Max(d[2 * k], d[(2 * k + 9) % 16]));
  };
  V best = nine(0);
  for (size_t k = 1; k < 8; ++k) best = hn::Max(best, nine(k));
  return best;
}

void FastScoreRow(const uint8_t* pixel, ptrdiff_t stride, int count, int threshold, uint8_t* out) {
  const hn::CappedTag<uint8_t, 64> tag;
  using V = hn::Vec<decltype(tag)>;
  const auto step = static_cast<int>(hn::Lanes(tag));
  const V t = hn::Set(tag, static_cast<uint8_t>(threshold));
  const V one = hn::Set(tag, 1);
  const std::array<ptrdiff_t, 16> circle = {
      3 * stride,  3 * stride + 1,  2 * stride + 2,  stride + 3,  3,  -stride + 3, -2 * stride + 2, -3 * stride + 1,
      -3 * stride, -3 * stride - 1, -2 * stride - 2, -stride - 3, -3, stride - 3,  2 * stride - 2,  3 * stride - 1};
  for (int x = 0; x < count; x += step) {
    const uint8_t* p = pixel + x;
    const V c = hn::LoadU(tag, p);
    const V high = hn::SaturatedAdd(c, t), low = hn::SaturatedSub(c, t);
    // Nine contiguous pixels contain one of each opposite pair.
    const V p0 = hn::LoadU(tag, p + circle[0]), p8 = hn::LoadU(tag, p + circle[8]);
    const V p4 = hn::LoadU(tag, p + circle[4]), p12 = hn::LoadU(tag, p + circle[12]);
    const V bright = hn::Min(hn::SaturatedSub(hn::Max(p0, p8), high), hn::SaturatedSub(hn::Max(p4, p12), high));
    const V dark = hn::Min(hn::SaturatedSub(low, hn::Min(p0, p8)), hn::SaturatedSub(low, hn::Min(p4, p12)));
    V score = hn::Zero(tag);
    if (!hn::AllTrue(tag, hn::Eq(hn::Or(bright, dark), score))) {
      V up[16], down[16];
      for (size_t k = 0; k < 16; ++k) {
        const V q = hn::LoadU(tag, p + circle[k]);
        up[k] = hn::SaturatedSub(q, c);
        down[k] = hn::SaturatedSub(c, q);
      }
      const V best = hn::Max(best_run(up), best_run(down));
      // Computes best > t ? best - 1 : 0.
      const V above = hn::SaturatedSub(best, t);
      score = hn::IfThenElse(hn::Eq(above, hn::Zero(tag)), hn::Zero(tag), hn::Sub(best, one));
    }
    if (x + step <= count) {
      hn::StoreU(score, tag, out + x);
    } else {
      HWY_ALIGN uint8_t rest[64];
      hn::StoreU(score, tag, rest);
      for (int k = 0; x + k < count; ++k) out[x + k] = rest[k];
    }
  }
}

int LocalMaximaRow(const uint8_t* above, const uint8_t* row, const uint8_t* below, int count, uint16_t* columns) {
  const hn::CappedTag<uint8_t, 64> tag;
  using V = hn::Vec<decltype(tag)>;
  const auto step = static_cast<int>(hn::Lanes(tag));
  int found = 0;
  for (int x = 0; x < count; x += step) {
    const V at = hn::LoadU(tag, row + x);
    if (hn::AllTrue(tag, hn::Eq(at, hn::Zero(tag)))) continue;  // most pixels are no corners
    const auto three = [&](const uint8_t* p) {
      return hn::Max(hn::LoadU(tag, p + x), hn::Max(hn::LoadU(tag, p + x - 1), hn::LoadU(tag, p + x + 1)));
    };
    const V sides = hn::Max(hn::LoadU(tag, row + x - 1), hn::LoadU(tag, row + x + 1));
    auto mask = hn::Gt(at, hn::Max(sides, hn::Max(three(above), three(below))));
    if (x + step > count) mask = hn::And(mask, hn::FirstN(tag, static_cast<size_t>(count - x)));
    uint64_t bits = 0;
    hn::StoreMaskBits(tag, mask, reinterpret_cast<uint8_t*>(&bits));
    for (; bits != 0; bits &= bits - 1) columns[found++] = static_cast<uint16_t>(x + __builtin_ctzll(bits));
  }
  return found;
}

void HammingRow(const Descriptor& a, const Descriptor* b, int n, uint16_t* out) {
  const hn::FixedTag<uint64_t, 2> two;
  const hn::Repartition<uint8_t, decltype(two)> bytes;
  const auto a0 = hn::LoadU(two, a.bits.data()), a1 = hn::LoadU(two, a.bits.data() + 2);
  for (int j = 0; j < n; ++j) {
    const uint64_t* q = b[j].bits.data();
    const auto c0 = hn::PopulationCount(hn::BitCast(bytes, hn::Xor(a0, hn::LoadU(two, q))));
    const auto c1 = hn::PopulationCount(hn::BitCast(bytes, hn::Xor(a1, hn::LoadU(two, q + 2))));
    const auto sum = hn::SumsOf8(hn::Add(c0, c1));
    out[j] = static_cast<uint16_t>(hn::GetLane(sum) + hn::GetLane(hn::UpperHalf(hn::Half<decltype(two)>(), sum)));
  }
}

}  // namespace covis::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace covis {
namespace {

HWY_EXPORT(FastScoreRow);
HWY_EXPORT(LocalMaximaRow);
HWY_EXPORT(HammingRow);

}  // namespace

void fast_score_row(const uint8_t* pixel, ptrdiff_t stride, int count, int threshold, uint8_t* out) {
  if (simd_enabled()) {
    HWY_DYNAMIC_DISPATCH(FastScoreRow)(pixel, stride, count, threshold, out);
  } else {
    for (int x = 0; x < count; ++x) out[x] = static_cast<uint8_t>(fast_score(pixel + x, stride, threshold));
  }
}

int local_maxima_row(const uint8_t* above, const uint8_t* row, const uint8_t* below, int count, uint16_t* columns) {
  if (simd_enabled()) return HWY_DYNAMIC_DISPATCH(LocalMaximaRow)(above, row, below, count, columns);
  int found = 0;
  for (int x = 0; x < count; ++x) {
    const uint8_t s = row[x];
    const auto below_s = [&](const uint8_t* p) { return p[x - 1] < s && p[x] < s && p[x + 1] < s; };
    if (row[x - 1] < s && row[x + 1] < s && below_s(above) && below_s(below))
      columns[found++] = static_cast<uint16_t>(x);
  }
  return found;
}

void hamming_row(const Descriptor& a, const Descriptor* b, int n, uint16_t* out) {
  if (simd_enabled()) {
    HWY_DYNAMIC_DISPATCH(HammingRow)(a, b, n, out);
  } else {
    for (int j = 0; j < n; ++j) out[j] = static_cast<uint16_t>(hamming(a, b[j]));
  }
}

}  // namespace covis
#endif
