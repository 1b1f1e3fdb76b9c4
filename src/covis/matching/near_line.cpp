// SPDX-License-Identifier: Apache-2.0
#include "covis/matching/near_line.h"

#include <type_traits>

#include "covis/core/simd_targets.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "covis/matching/near_line.cpp"
#include <hwy/foreach_target.h>
// after foreach_target
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace covis::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

size_t NearLine(const float* line, const LinePoints& points, uint32_t* index) {
  const hn::CappedTag<float, 16> d;
  constexpr size_t kLanes = hn::MaxLanes(d);
  using MaskBits = std::conditional_t<kLanes == 16, uint16_t, uint8_t>;
  const auto a = hn::Set(d, line[0]), b = hn::Set(d, line[1]), c = hn::Set(d, line[2]);
  size_t found = 0;
  for (size_t step = 0; step < points.padded(); step += LinePoints::kStep) {
    // One bit for each point, and a loop over the few that are set: it is left by one branch in 64 points.
    uint64_t bits = 0;
    for (size_t i = 0; i < LinePoints::kStep; i += kLanes) {
      const size_t k = step + i;
      const auto residual =
          hn::Add(hn::Add(hn::Mul(a, hn::Load(d, points.x() + k)), hn::Mul(b, hn::Load(d, points.y() + k))), c);
      MaskBits near = 0;
      hn::StoreMaskBits(d, hn::Le(hn::Mul(residual, residual), hn::Load(d, points.bound() + k)),
                        reinterpret_cast<uint8_t*>(&near));
      bits |= static_cast<uint64_t>(near) << i;
    }
    for (; bits != 0; bits &= bits - 1)
      index[found++] = static_cast<uint32_t>(step) + static_cast<uint32_t>(__builtin_ctzll(bits));
  }
  return found;
}

}  // namespace covis::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace covis {
namespace {

HWY_EXPORT(NearLine);

}  // namespace

size_t near_line(const std::array<float, 3>& line, const LinePoints& points, uint32_t* index) {
  if (simd_enabled()) return HWY_DYNAMIC_DISPATCH(NearLine)(line.data(), points, index);
  size_t found = 0;
  for (size_t k = 0; k < points.size(); ++k) {
    const float residual = line[0] * points.x()[k] + line[1] * points.y()[k] + line[2];
    if (residual * residual <= points.bound()[k]) index[found++] = static_cast<uint32_t>(k);
  }
  return found;
}

}  // namespace covis
#endif
