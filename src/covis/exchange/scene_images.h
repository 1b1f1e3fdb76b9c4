// SPDX-License-Identifier: Apache-2.0
// The key frames' images of a scene, as its pinhole camera would have taken them.
#pragma once

#include <cstddef>
#include <filesystem>

#include "covis/core/error.h"
#include "covis/exchange/scene.h"

namespace covis::exchange {

// Takes the images of the views from the folder in which `covis run --keep-images` left them, and writes them to
// another folder, which is made, as the views' cameras would have taken them; where that is how they were taken, they
// are copied. Sets SceneView::image, empty for views that have no image there. Returns how many have one. Error: a
// folder that is not there or the one to write to, an image that is damaged or of another size than its camera's, and
// one that would replace another one, where another model needs those that are there.
Result<size_t> write_images(const std::filesystem::path& kept, const std::filesystem::path& folder, Scene& scene,
                            bool may_replace = true);

}  // namespace covis::exchange
