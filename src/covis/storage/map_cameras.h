// SPDX-License-Identifier: Apache-2.0
// The sections of a map file that name the cameras of key frames that another camera than the map's made, and the
// residual distortion of cameras (docs/map-format.md, sections 9 and 10). Other files have none.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "covis/geometry/camera.h"
#include "covis/map/map_state.h"

namespace covis::storage {

inline constexpr uint32_t kCameras = 9, kResiduals = 10;  // ids of the sections

struct KeyFrameCameras {
  std::vector<RefinedCamera> cameras;
  std::vector<uint32_t> of;  // for each key frame 0, the map's own camera, or 1 + index into `cameras`
};

KeyFrameCameras cameras_of(const MapState& map);
std::string bytes_of(const KeyFrameCameras& cameras);
// Reads the section of a file with so many key frames. Returns what is wrong with the bytes, or nothing.
std::string read_cameras(std::string_view bytes, size_t key_frames, KeyFrameCameras& cameras);

// The residual distortion of the map's camera, and of those of key frames.
bool have_residuals(const Pinhole& own, const KeyFrameCameras& cameras);
std::string bytes_of_residuals(const Pinhole& own, const KeyFrameCameras& cameras);
// Reads the section into these cameras. Returns what is wrong with the bytes, or nothing.
std::string read_residuals(std::string_view bytes, Pinhole& own, KeyFrameCameras& cameras);

}  // namespace covis::storage
