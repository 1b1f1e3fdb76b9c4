// SPDX-License-Identifier: Apache-2.0
// For the tests of matching: descriptors near each other.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "covis/features/test_features.h"

namespace covis {

// The same descriptor with `bits` of its bits turned.
inline Descriptor turned(Descriptor d, int bits, Random& random) {
  std::vector<uint32_t> order(256);
  for (uint32_t i = 0; i < 256; ++i) order[i] = i;
  for (uint32_t i = 0; i < static_cast<uint32_t>(bits); ++i) {
    std::swap(order[i], order[i + random.below(256 - i)]);
    d.bits[order[i] / 64] ^= uint64_t{1} << (order[i] % 64);
  }
  return d;
}

inline void add(Features& f, float x, float y, int level, const Descriptor& d) {
  add(f, {.x = x, .y = y, .level = level, .descriptor = d});
}

}  // namespace covis
