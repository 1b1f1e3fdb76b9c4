// SPDX-License-Identifier: Apache-2.0
// Rules that decide whether a saved map can be used in a run.
//
// The map's features are matched by descriptors at the same scales, so that the pyramids must have the same factor (not
// as many levels), and in one unit of length: a camera without depth can be localised in a map in metres, which tells
// it the unit, and not continue it; one with depth can do neither in a map that a camera without depth made. The camera
// may be another one (map/camera_change.h), and so may the vocabulary: the words of the key frames are recomputed when
// a map is loaded.
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

// The header of a saved map once a run has taken it in place: the saved camera's figures, where it is the same one, and
// its sensor, where a camera without depth is localised in a map in metres.
MapHeader header_after(const MapHeader& run, const MapHeader& saved);

// The error names the mismatch and the setting that would resolve it. `run` is the header that a map of this run would
// have.
Result<void> check_compatible(const MapHeader& saved, const MapHeader& run, MapUse use);

// Succeeds when a map can become one with another: their features are of one kind. The error says how they differ.
Result<void> check_mergeable(const MapHeader& first, const MapHeader& other);

// Loads a map for a run; fails when it does not fit or has no key frames. Errors name the file.
Result<SavedMap> load_compatible_map(const std::filesystem::path& file, const MapHeader& run, MapUse use);

}  // namespace covis::storage
