// SPDX-License-Identifier: Apache-2.0
// Point clouds.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <vector>

#include "covis/core/error.h"

namespace covis::io {

// Binary little-endian PLY with float x, y, z. Written whole or not at all.
Result<void> write_ply(const std::filesystem::path& file, const std::vector<Eigen::Vector3d>& points);

}  // namespace covis::io
