// SPDX-License-Identifier: Apache-2.0
// The bytes of a map file.
#pragma once

#include "covis/core/atomic_file.h"
#include "covis/map/map_state.h"
#include "covis/storage/map_file.h"

namespace covis::storage {

// Writes section by section, and the features, which are most of a map, key frame by key frame: that takes
// little memory beside the map, which must be sound. An error where a reader would refuse the file.
Result<void> write_map(FileSink& sink, const MapState& map, const MapHeader& header);

}  // namespace covis::storage
