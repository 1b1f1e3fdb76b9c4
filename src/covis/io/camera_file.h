// SPDX-License-Identifier: Apache-2.0
// The camera YAML: what a recording does not say about its camera. docs/input.md has a complete example.
#pragma once

#include <filesystem>
#include <string>

#include "covis/core/error.h"
#include "covis/geometry/camera.h"

namespace covis::io {

struct CameraFile {
  std::filesystem::path file;  // its name on disk
  Camera camera;               // pinhole.bf is fx * baseline when a baseline is given, else 0
  double baseline = 0;         // metres; 0: not given
  double fps = 0;              // Hz; 0: not given
  double depth_scale = 0;      // units of a depth image a metre; 0: not given
};

// Errors name the file, the line, the key and what would be right; an unknown key gets the nearest known one.
Result<CameraFile> load_camera(const std::filesystem::path& file);
// The text load_camera() reads.
std::string camera_text(const CameraFile& file);

}  // namespace covis::io
