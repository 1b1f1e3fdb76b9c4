// SPDX-License-Identifier: Apache-2.0
// Opens what can be viewed: the results of a run, or a saved map.
#pragma once

#include <filesystem>

#include "apps/view/view_state.h"
#include "covis/core/error.h"

namespace covis::view {

inline constexpr const char* kSceneFile = "scene.bin";

// path: a folder that `covis run` wrote, or a saved map. The error names the file and what would be right.
Result<ViewState> open_view(const std::filesystem::path& path);

}  // namespace covis::view
