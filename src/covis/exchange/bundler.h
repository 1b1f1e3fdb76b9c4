// SPDX-License-Identifier: Apache-2.0
// Scenes as Bundler writes them: bundle.out of version 0.3 and list.txt (Snavely, Seitz, Szeliski, "Photo Tourism",
// 2006; Bundler's user manual, section "Output format"). There a camera looks along -z with y up, and has one focal
// length; pixels count from the image's centre with y up.
#pragma once

#include <filesystem>

#include "covis/core/error.h"
#include "covis/exchange/scene.h"

namespace covis::exchange {

// Writes both files into a folder, which is made. The scene is centred() and after keep_tracks() (both asserted).
// `images`: the folder of the images in list.txt, relative to it.
Result<void> write_bundler(const std::filesystem::path& folder, const Scene& scene, const std::string& images);

}  // namespace covis::exchange
