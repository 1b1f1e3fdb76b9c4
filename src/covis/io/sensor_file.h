// SPDX-License-Identifier: Apache-2.0
// The camera files of EuRoC sequences (cam0/sensor.yaml), which Kimera has too (LeftCameraParams.yaml).
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "covis/core/error.h"
#include "covis/geometry/camera.h"
#include "covis/geometry/se3.h"

namespace covis::io {

struct SensorFile {
  Camera camera;
  SE3 T_bs;         // sensor to body
  double rate = 0;  // Hz; 0: not given
};

// Errors name file and field.
Result<SensorFile> read_sensor_file(const std::filesystem::path& file);
// Returns text that read_sensor_file() can read.
std::string sensor_file_text(const SensorFile& sensor);

// Lens models by the names that EuRoC, Kalibr, Kimera and ROS have for them; nullopt: none of Covis is it.
std::optional<Distortion> distortion_named(const std::string& name);

}  // namespace covis::io
