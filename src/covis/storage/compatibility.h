// SPDX-License-Identifier: Apache-2.0
// The rules that decide whether a saved map fits a run.
//
// What the map holds is found again by its descriptors, at the same scales and in the same unit of length: sensor and
// pyramid must be alike. A map that is continued has one camera, to which all of it is adjusted; localisation alone
// may use another one. The vocabulary may be another: the words of the key frames are computed anew when a map is
// loaded.
#pragma once

#include <filesystem>

#include "covis/core/error.h"
#include "covis/storage/map_file.h"

namespace covis::storage {

enum class MapUse { continuation, localization };

// An error says what does not fit, and which setting would. `run` is the header a map of this run would have.
Result<void> check_compatible(const MapHeader& saved, const MapHeader& run, MapUse use);

// Loads a map for a run: an error when it does not fit or has no key frames. Errors name the file.
Result<SavedMap> load_compatible_map(const std::filesystem::path& file, const MapHeader& run, MapUse use);

}  // namespace covis::storage
