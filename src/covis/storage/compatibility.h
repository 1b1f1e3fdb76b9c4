// SPDX-License-Identifier: Apache-2.0
// Rules that decide whether a saved map can be used in a run.
//
// The map's features are matched by descriptors at the same scales and in the same unit of length, so sensor and
// pyramid must agree. A continued map has one camera, to which all of it is adjusted; localisation alone may use
// another camera. The vocabulary may differ: the words of the key frames are recomputed when a map is loaded.
#pragma once

#include <filesystem>

#include "covis/core/error.h"
#include "covis/features/frontend.h"
#include "covis/storage/map_file.h"
#include "covis/vocabulary/vocabulary.h"

namespace covis::storage {

enum class MapUse { continuation, localization };

// The header of a map made with this camera, these features and this vocabulary (null: none).
MapHeader header_of(const Camera& camera, Sensor sensor, const OrbOptions& orb, const Vocabulary* vocabulary);

// The error names the mismatch and the setting that would resolve it. `run` is the header that a map of this run would
// have.
Result<void> check_compatible(const MapHeader& saved, const MapHeader& run, MapUse use);

// Succeeds when a map can become one with another: key frames of one camera, with features of one kind. The error names
// all that differs.
Result<void> check_mergeable(const MapHeader& first, const MapHeader& other);

// Loads a map for a run; fails when it does not fit or has no key frames. Errors name the file.
Result<SavedMap> load_compatible_map(const std::filesystem::path& file, const MapHeader& run, MapUse use);

}  // namespace covis::storage
