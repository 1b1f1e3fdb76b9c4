// SPDX-License-Identifier: Apache-2.0
// One descriptor against many: the nearest and the next, and for each of the many the nearest so far.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "covis/features/features.h"

namespace covis {

// A distance and whose it is in one number, so that the least of two is the nearer one, on a tie the one of lower
// index.
inline constexpr int kNearIndexBits = 32;
inline constexpr uint64_t kFarthest = uint64_t{kHammingBeyond} << kNearIndexBits;
inline uint64_t near_key(int distance, uint32_t index) { return uint64_t(distance) << kNearIndexBits | index; }
inline int near_distance(uint64_t key) { return static_cast<int>(key >> kNearIndexBits); }
inline uint32_t near_index(uint64_t key) { return static_cast<uint32_t>(key); }

// Descriptors of some features, those with use[i] != 0 (empty span: all), laid out so that lanes go over features.
class DescriptorPlanes {
 public:
  static constexpr size_t kStep = 8;  // the lanes of the widest vectors: planes are padded to a multiple of it

  DescriptorPlanes() = default;
  DescriptorPlanes(const Features& features, std::span<const uint8_t> use) { assign(features, use); }
  // Allocates only when there are more than ever before, or than was reserved.
  void assign(const Features& features, std::span<const uint8_t> use);
  void reserve(size_t features);
  size_t size() const { return feature_.size(); }
  size_t padded_size() const { return plane_[0].size(); }
  const uint64_t* plane(size_t k) const { return plane_[k].data(); }  // bits 64 k to 64 k + 63
  int32_t feature(size_t position) const { return feature_[position]; }

 private:
  std::array<AlignedVector<uint64_t>, 4> plane_;
  std::vector<int32_t> feature_;
};

struct NearestTwo {
  uint64_t best = kFarthest, second = kFarthest;  // keys; the index is a position in the planes
};

// The two nearest of `many` to `a`. column[j], for j in [0, many.padded_size()), becomes near_key(distance to j,
// a_index) where that is less.
NearestTwo nearest_row(const Descriptor& a, uint32_t a_index, const DescriptorPlanes& many, uint64_t* column);

}  // namespace covis
