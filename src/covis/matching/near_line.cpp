// SPDX-License-Identifier: Apache-2.0
#include "covis/matching/near_line.h"

#include "covis/features/simd.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "covis/matching/near_line.cpp"
#include <hwy/foreach_target.h>
// after foreach_target
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace covis::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

size_t NearLine(const float* line, const LinePoints& points, uint32_t* index) {
  const hn::CappedTag<float, LinePoints::kStep> d;
  const hn::RebindToUnsigned<decltype(d)> du;
  const size_t lanes = hn::Lanes(d), n = points.padded();
  const auto a = hn::Set(d, line[0]), b = hn::Set(d, line[1]), c = hn::Set(d, line[2]);
  size_t found = 0;
  for (size_t k = 0; k < n; k += lanes) {
    const auto residual =
        hn::Add(hn::Add(hn::Mul(a, hn::Load(d, points.x() + k)), hn::Mul(b, hn::Load(d, points.y() + k))), c);
    const auto near = hn::Le(hn::Mul(residual, residual), hn::Load(d, points.bound() + k));
    if (hn::AllFalse(d, near)) continue;
    found += hn::CompressStore(hn::Iota(du, static_cast<uint32_t>(k)), hn::RebindMask(du, near), du, index + found);
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
