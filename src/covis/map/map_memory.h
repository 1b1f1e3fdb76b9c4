// SPDX-License-Identifier: Apache-2.0
// How much memory a map takes.
#pragma once

#include <cstddef>

#include "covis/map/map.h"

namespace covis {

// Bytes of its key frames, points and the database of words, counted by what they hold: the same for the same map on
// every machine, and without colours, which come when they come: three bytes a keypoint. Resident memory grows by some
// 15 % more (docs/notes/014-memory-and-growth.md). Looks at every point.
size_t memory_of(const Map& map);

}  // namespace covis
