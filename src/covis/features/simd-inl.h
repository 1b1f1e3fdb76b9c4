// SPDX-License-Identifier: Apache-2.0
// Shared by the kernels; included once for each instruction set, after hwy/highway.h.
#if defined(COVIS_FEATURES_SIMD_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef COVIS_FEATURES_SIMD_INL_H
#undef COVIS_FEATURES_SIMD_INL_H
#else
#define COVIS_FEATURES_SIMD_INL_H
#endif

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace covis::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

// a[2 i] b[2 i] + a[2 i + 1] b[2 i + 1], for i in the lanes of d32.
template <class D32, class V16>
HWY_INLINE hn::Vec<D32> pair_sums(D32 d32, V16 a, V16 b) {
#if HWY_ARCH_X86 && HWY_TARGET != HWY_EMU128 && HWY_TARGET != HWY_SCALAR
  auto unused = hn::Zero(d32);
  return hn::ReorderWidenMulAccumulate(d32, a, b, hn::Zero(d32), unused);  // pmaddwd, neighbours together
#else
  const auto a32 = hn::BitCast(d32, a), b32 = hn::BitCast(d32, b);
  const auto low = [](auto v) { return hn::ShiftRight<16>(hn::ShiftLeft<16>(v)); };
  return hn::Add(hn::Mul(low(a32), low(b32)), hn::Mul(hn::ShiftRight<16>(a32), hn::ShiftRight<16>(b32)));
#endif
}

}  // namespace covis::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
