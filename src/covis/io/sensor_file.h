// SPDX-License-Identifier: Apache-2.0
// The camera files of EuRoC sequences (cam0/sensor.yaml), which Kimera has too (LeftCameraParams.yaml).
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "covis/core/error.h"
#include "covis/geometry/camera.h"
#include "covis/geometry/se3.h"

namespace YAML {
class Node;
}

namespace covis::io {

struct SensorFile {
  Camera camera;
  SE3 T_bs;         // sensor to body
  double rate = 0;  // Hz; 0: not given
};

// Errors name file and field.
Result<SensorFile> read_sensor_file(const std::filesystem::path& file);
// Reads T_bs alone, whatever the file says of the camera.
Result<SE3> read_sensor_pose(const std::filesystem::path& file);
// Returns text that read_sensor_file() can read.
std::string sensor_file_text(const SensorFile& sensor);

// Lens models by the names that EuRoC, Kalibr, Kimera and ROS have for them; nullopt: none of Covis is it.
std::optional<Distortion> distortion_named(const std::string& name);
// Reads the four `intrinsics` of a camera, whose `camera_model` must be pinhole where there is one.
Result<std::vector<double>> read_intrinsics(const std::filesystem::path& file, const YAML::Node& camera);
// Reads the coefficients of a lens that is not Distortion::none. Errors where there are more than it has.
Result<std::array<double, 5>> read_coefficients(const std::filesystem::path& file, const YAML::Node& camera,
                                                const char* key, Distortion lens);

}  // namespace covis::io
