// SPDX-License-Identifier: Apache-2.0
#include "covis/matching/nearest_row.h"

#include <algorithm>

#include "covis/core/simd_targets.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "covis/matching/nearest_row.cpp"
#include <hwy/foreach_target.h>
// after foreach_target
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace covis::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

NearestTwo NearestRow(const Descriptor& a, uint32_t a_index, const DescriptorPlanes& many, uint64_t* column) {
  const hn::CappedTag<uint64_t, DescriptorPlanes::kStep> d;
  const hn::Repartition<uint8_t, decltype(d)> bytes;
  const size_t lanes = hn::Lanes(d), n = many.size();
  const auto a0 = hn::Set(d, a.bits[0]), a1 = hn::Set(d, a.bits[1]), a2 = hn::Set(d, a.bits[2]),
             a3 = hn::Set(d, a.bits[3]);
  const auto owner = hn::Set(d, a_index), end = hn::Set(d, n), step = hn::Set(d, lanes);
  auto index = hn::Iota(d, 0), best = hn::Set(d, kFarthest), second = best;
  for (size_t j = 0; j < n; j += lanes) {
    // The bits of a byte are counted in all four words before the bytes are summed, which takes longest.
    const auto turned = [&](auto bits, size_t k) {
      return hn::PopulationCount(hn::BitCast(bytes, hn::Xor(bits, hn::Load(d, many.plane(k) + j))));
    };
    const auto distance =
        hn::SumsOf8(hn::Add(hn::Add(turned(a0, 0), turned(a1, 1)), hn::Add(turned(a2, 2), turned(a3, 3))));
    const auto high = hn::ShiftLeft<kNearIndexBits>(distance);
    hn::Store(hn::Min(hn::Load(d, column + j), hn::Or(high, owner)), d, column + j);
    // The padding of the planes is nobody's nearest.
    const auto key = hn::IfThenElse(hn::Lt(index, end), hn::Or(high, index), hn::Set(d, kFarthest));
    second = hn::Min(second, hn::Max(best, key));
    best = hn::Min(best, key);
    index = hn::Add(index, step);
  }
  HWY_ALIGN uint64_t each_best[DescriptorPlanes::kStep], each_second[DescriptorPlanes::kStep];
  hn::Store(best, d, each_best);
  hn::Store(second, d, each_second);
  NearestTwo two;
  for (size_t k = 0; k < lanes; ++k) {
    two.second = std::min({std::max(two.best, each_best[k]), two.second, each_second[k]});
    two.best = std::min(two.best, each_best[k]);
  }
  return two;
}

}  // namespace covis::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace covis {
namespace {

HWY_EXPORT(NearestRow);

}  // namespace

void DescriptorPlanes::reserve(size_t features) {
  for (auto& plane : plane_) plane.reserve(features);
  feature_.reserve(features);
}

void DescriptorPlanes::assign(const Features& features, std::span<const uint8_t> use) {
  feature_.clear();
  for (size_t i = 0; i < features.descriptor.size(); ++i) {
    if (use.empty() || use[i]) feature_.push_back(static_cast<int32_t>(i));
  }
  for (size_t k = 0; k < plane_.size(); ++k) {
    plane_[k].resize((feature_.size() + kStep - 1) / kStep * kStep);
    for (size_t j = 0; j < feature_.size(); ++j)
      plane_[k][j] = features.descriptor[static_cast<size_t>(feature_[j])].bits[k];
  }
}

NearestTwo nearest_row(const Descriptor& a, uint32_t a_index, const DescriptorPlanes& many, uint64_t* column) {
  if (simd_enabled()) return HWY_DYNAMIC_DISPATCH(NearestRow)(a, a_index, many, column);
  NearestTwo two;
  for (uint32_t j = 0; j < many.size(); ++j) {
    int distance = 0;
    for (size_t k = 0; k < a.bits.size(); ++k) distance += __builtin_popcountll(a.bits[k] ^ many.plane(k)[j]);
    column[j] = std::min(column[j], near_key(distance, a_index));
    const uint64_t key = near_key(distance, j);
    two.second = std::min(two.second, std::max(two.best, key));
    two.best = std::min(two.best, key);
  }
  return two;
}

}  // namespace covis
#endif
