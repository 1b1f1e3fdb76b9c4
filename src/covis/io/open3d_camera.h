// SPDX-License-Identifier: Apache-2.0
// Cameras as Open3D writes them: JSON with width, height and intrinsic_matrix, whose columns follow each other.
#pragma once

#include <filesystem>

#include "covis/core/error.h"
#include "covis/geometry/camera.h"

namespace covis::io {

// Errors name file and field.
Result<Camera> read_open3d_camera(const std::filesystem::path& file);

}  // namespace covis::io
