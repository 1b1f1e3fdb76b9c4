// SPDX-License-Identifier: Apache-2.0
// Output of point clouds.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <vector>

#include "covis/core/error.h"
#include "covis/core/sensor.h"
#include "covis/types.h"

namespace covis::io {

struct CloudPoint {
  Eigen::Vector3d position;  // in CloudUnit
  Colour colour = kNoColour;
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();  // unit length, or zero: not known
};

// of_map: that of a map of one camera alone, of which nobody knows how long it is.
enum class CloudUnit { metres, of_map };

// Returns the unit of a map of the sensor.
inline CloudUnit unit_of(Sensor sensor) { return sensor == Sensor::monocular ? CloudUnit::of_map : CloudUnit::metres; }

// Writes a binary little-endian PLY file, completely or not at all: float x, y, z; float nx, ny, nz where any point has
// a normal; uchar red, green, blue where any has a colour or a normal.
Result<void> write_ply(const std::filesystem::path& file, const std::vector<CloudPoint>& points,
                       CloudUnit unit = CloudUnit::metres);

}  // namespace covis::io
