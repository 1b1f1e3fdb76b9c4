// SPDX-License-Identifier: Apache-2.0
// --max-memory: how much of a run's memory its map may take.
#pragma once

#include <cstdint>

#include "covis/core/error.h"
#include "covis/geometry/camera.h"

namespace covis::app {

// Returns the map's part (mapper.max_map_mb) of `megabytes` for the whole process. The rest is for the program, images
// in several stages, the vocabulary, and the adjustment and saving of a map beside it, which take more than the map
// itself (docs/notes/014-memory-and-growth.md). An error when too little is left for a map.
Result<int> map_megabytes(int megabytes, const Camera& camera, uint64_t vocabulary_bytes);

// Gives arrays of more than 4 kB, which are most of what a key frame has, pages of their own where no free piece of the
// heap fits; these leave the process when the key frame goes, where a larger heap would keep gaps that never quite fit
// what comes next. Must be called before there are other threads; does nothing without the GNU C library.
void return_memory_at_once();

}  // namespace covis::app
