// SPDX-License-Identifier: Apache-2.0
// Cameras out of the YAML and JSON files of other programs: Kalibr's camera chains, EuRoC's and Kimera's sensor files,
// ROS' camera_info (as OpenCV writes it too), Open3D's intrinsics. Sources:
// github.com/ethz-asl/kalibr/wiki/yaml-formats, Kimera's parameter files, wiki.ros.org/camera_calibration_parsers.
// COLMAP's: exchange/camera_import.h.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "covis/core/error.h"
#include "covis/io/camera_file.h"
#include "covis/io/sensor_file.h"

namespace covis::io {

// A stereo pair whose images are to be rectified while they are read. The body is the left camera.
struct SensorPair {
  SensorFile left, right;
};

struct ImportedCamera {
  std::string format;              // "Kalibr camera chain"
  CameraFile file;                 // the only or left camera; with a baseline where the pair's images are rectified
  std::optional<SensorPair> pair;  // a pair that no camera file can describe
  std::vector<std::string> notes;  // figures of the file that are not used
};

// Returns nullopt for a file of none of these kinds. Errors name file and field. What is returned lies in the bounds of
// load_camera().
Result<std::optional<ImportedCamera>> import_camera_yaml(const std::filesystem::path& file);

// Fails when load_camera() would refuse the camera.
Result<void> check_camera_bounds(const std::filesystem::path& file, const Camera& camera);

}  // namespace covis::io
