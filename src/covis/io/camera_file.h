// SPDX-License-Identifier: Apache-2.0
// The camera YAML file: camera data that a recording does not contain. docs/input.md has a complete example.
#pragma once

#include <filesystem>
#include <string>

#include "covis/core/error.h"
#include "covis/geometry/camera.h"

namespace covis::io {

struct CameraFile {
  std::filesystem::path file;  // the file it was read from
  Camera camera;               // pinhole.bf is fx * baseline when a baseline is given, else 0
  double baseline = 0;         // metres; 0: not given
  double fps = 0;              // Hz; 0: not given
  double depth_scale = 0;      // units of a depth image per metre; 0: not given
  int bits = 16;               // number of the 16 of an image that the camera fills, from the lowest on
};

// Errors name the file, the line, the key and the accepted values; an unknown key gets the nearest known one.
Result<CameraFile> load_camera(const std::filesystem::path& file);
// Returns text that load_camera() can read.
std::string camera_text(const CameraFile& file);

}  // namespace covis::io
