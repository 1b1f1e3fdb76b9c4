// SPDX-License-Identifier: Apache-2.0
// Maps saved to one file and loaded again (docs/map-format.md). The loaded map is the saved one in everything that
// mapping goes on from; handles are new: key frames by rising serial, points in their order, from slot 0. Saving what
// was loaded gives the same bytes.
//
// Errors name the file and what is wrong with it. A damaged, cut off or foreign file is an error, never less of a map.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "covis/core/error.h"
#include "covis/core/sensor.h"
#include "covis/geometry/camera.h"
#include "covis/map/map.h"
#include "covis/map/map_state.h"

namespace covis::storage {

// The camera and the settings the map was made with.
struct MapHeader {
  Camera camera;
  Sensor sensor = Sensor::monocular;
  int levels = 0;          // levels of the scale pyramid
  float factor = 0;        // between its levels
  std::string vocabulary;  // its checksum as text; empty: made without one
};

struct SavedMap {
  MapHeader header;
  Map map;
};

struct MapInfo {
  MapHeader header;
  uint16_t major = 0, minor = 0;  // version of the format
  uint64_t file_size = 0;         // bytes
  uint64_t key_frames = 0, points = 0, observations = 0, features = 0;
  uint64_t submaps = 0;                              // maps that are not joined
  Eigen::Vector3d extent = Eigen::Vector3d::Zero();  // metres: sides of the box around the key frames' centres
  double seconds = 0;                                // from the first to the last key frame's stamp
};

// Writes to a temporary name in the same folder, waits for the disk and renames: whatever happens meanwhile, `file` is
// the old one or the new one, whole. Take the state under the map's lock and save it without. An error too when the map
// is not sound, for what is written can be read again.
Result<void> save_map(const std::filesystem::path& file, const MapState& map, const MapHeader& header);

Result<SavedMap> load_map(const std::filesystem::path& file);

// Reads what the file says of itself and the key frames' poses, but neither features nor points: quick, and no check of
// those.
Result<MapInfo> read_map_info(const std::filesystem::path& file);

}  // namespace covis::storage
