// SPDX-License-Identifier: Apache-2.0
// Output of point clouds.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <vector>

#include "covis/core/error.h"

namespace covis::io {

// Writes a binary little-endian PLY file with float x, y, z, completely or not at all.
Result<void> write_ply(const std::filesystem::path& file, const std::vector<Eigen::Vector3d>& points);

}  // namespace covis::io
