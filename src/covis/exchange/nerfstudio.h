// SPDX-License-Identifier: Apache-2.0
// Scenes for nerfstudio and other trainers of radiance fields and Gaussian splats: transforms.json
// (https://docs.nerf.studio/quickstart/data_conventions.html) and the points as a PLY file beside it. There a camera
// looks along -z with y up, poses are camera to world, the world's z is up, and the centre of the first pixel is at
// (0.5, 0.5).
#pragma once

#include <filesystem>

#include "covis/core/error.h"
#include "covis/exchange/scene.h"
#include "covis/io/outputs.h"

namespace covis::exchange {

// Writes `name`.json and `name`.ply into a folder, which is made. `images`: the folder of the images, relative to it;
// `unit`: that of the map.
Result<void> write_nerfstudio(const std::filesystem::path& folder, const std::string& name, const Scene& scene,
                              const std::string& images, io::CloudUnit unit = io::CloudUnit::metres);

}  // namespace covis::exchange
