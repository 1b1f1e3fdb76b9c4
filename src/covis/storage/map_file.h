// SPDX-License-Identifier: Apache-2.0
// Maps saved to one file and loaded again (docs/map-format.md). The loaded map equals the saved one in everything that
// mapping needs to continue. Handles are new: key frames by ascending serial and points in their order, from slot 0.
// Saving a loaded map gives the same bytes.
//
// Errors name the file and the defect. A damaged, truncated or foreign file is an error; a map is never loaded in part.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "covis/core/error.h"
#include "covis/core/sensor.h"
#include "covis/geometry/camera.h"
#include "covis/map/map.h"
#include "covis/map/map_state.h"

namespace covis::storage {

// Camera and settings with which the map was made.
struct MapHeader {
  Camera camera;
  Sensor sensor = Sensor::monocular;
  int levels = 0;          // number of levels of the scale pyramid
  float factor = 0;        // scale factor between levels
  std::string vocabulary;  // checksum as text; empty: made without a vocabulary
};

struct SavedMap {
  MapHeader header;
  Map map;
};

// A camera that made some of a map's key frames, and is not the map's own.
struct OtherCamera {
  Camera given;
  uint64_t key_frames = 0;
};

struct MapInfo {
  MapHeader header;
  Pinhole camera;                 // the header's, as it was refined
  uint16_t major = 0, minor = 0;  // version of the format
  uint64_t file_size = 0;         // bytes
  uint64_t key_frames = 0, points = 0, observations = 0, features = 0;
  std::vector<OtherCamera> other_cameras;            // those of the other key frames are the header's
  uint64_t submaps = 0;                              // number of maps that are not joined
  Eigen::Vector3d extent = Eigen::Vector3d::Zero();  // sides of the box around the key frames' centres, metres
  double seconds = 0;                                // time from the first to the last key frame's stamp
};

// Writes to a temporary name in the same folder, waits for the disk and renames: at any moment `file` is either the
// complete old or the complete new file. Take the state under the map's lock and save it without the lock. Fails for a
// map that is not sound, because such a file could not be loaded, and where something else than a map stands: of files,
// only maps of Covis and empty ones are replaced.
Result<void> save_map(const std::filesystem::path& file, const MapState& map, const MapHeader& header);

// Says before a run whether save_map() could write there after it: no file of another kind stands there, and the folder
// takes new files.
Result<void> check_save_target(const std::filesystem::path& file);

Result<SavedMap> load_map(const std::filesystem::path& file);

// Reads the header and the key frames' poses, but neither features nor points. It is fast and does not check those.
Result<MapInfo> read_map_info(const std::filesystem::path& file);

}  // namespace covis::storage
