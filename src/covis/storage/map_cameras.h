// SPDX-License-Identifier: Apache-2.0
// The section of a map file that names the cameras of key frames that another camera than the map's made
// (docs/map-format.md, section 9). Other files have none.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "covis/geometry/camera.h"
#include "covis/map/map_state.h"

namespace covis::storage {

inline constexpr uint32_t kCameras = 9;  // id of the section

struct KeyFrameCameras {
  std::vector<RefinedCamera> cameras;
  std::vector<uint32_t> of;  // for each key frame 0, the map's own camera, or 1 + index into `cameras`
};

KeyFrameCameras cameras_of(const MapState& map);
std::string bytes_of(const KeyFrameCameras& cameras);
// Reads the section of a file with so many key frames. Returns what is wrong with the bytes, or nothing.
std::string read_cameras(std::string_view bytes, size_t key_frames, KeyFrameCameras& cameras);

}  // namespace covis::storage
