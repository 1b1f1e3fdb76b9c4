// SPDX-License-Identifier: Apache-2.0
// Models of COLMAP in its text format (https://colmap.github.io/format.html): cameras.txt, images.txt, points3D.txt.
// There the centre of the first pixel is at (0.5, 0.5); ids count from 1, that of an image is its key frame's serial
// + 1.
#pragma once

#include <filesystem>

#include "covis/core/error.h"
#include "covis/exchange/scene.h"

namespace covis::exchange {

// Writes the model into a folder, which is made; the scene after keep_tracks() (asserted).
Result<void> write_colmap(const std::filesystem::path& folder, const Scene& scene);

}  // namespace covis::exchange
