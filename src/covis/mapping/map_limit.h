// SPDX-License-Identifier: Apache-2.0
// Keeps a growing map within a bound of memory, by giving up the key frames whose loss costs least.
#pragma once

#include <cstddef>

#include "covis/map/shared_map.h"

namespace covis {

// When the map takes more than `most` bytes (map/map_memory.h), erases key frames until it takes some 5 % less, at most
// 64 at a time. Those
// that the newest ones need stay: what is tracked and mapped now is as it would be without a bound. `current`: the
// newest key frame; it is looked at every so many of them alone. For the one thread that writes to the map.
struct LimitReport {
  int erased = 0;                // key frames
  bool is_out_of_reach = false;  // all that is left is needed
};
LimitReport limit_map(SharedMap& shared, KeyFrameId current, size_t most);

}  // namespace covis
