// SPDX-License-Identifier: Apache-2.0
// Keeps a growing map within a bound of memory, by giving up the key frames whose loss costs least.
#pragma once

#include <cstddef>

#include "covis/map/shared_map.h"

namespace covis {

struct LimitReport {
  int erased = 0;                // key frames
  bool is_out_of_reach = false;  // the map is too large, and all that is left of it is needed
};

// When the map takes more than `most` bytes (map/map_memory.h), erases key frames until it takes some 5 % less, at most
// 64 in a call. The newest 50 stay, and those that share points with `current`: tracking and mapping go on as they
// would without a bound, but for points that one of the 50 saw together with an old key frame alone. `current`: the
// newest key frame; the map is measured at every eighth. For the one thread that writes to the map.
LimitReport limit_map(SharedMap& shared, KeyFrameId current, size_t most);

}  // namespace covis
