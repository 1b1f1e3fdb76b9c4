// SPDX-License-Identifier: Apache-2.0
// Shared by the commands that run the system: a vocabulary, and the header of a saved map.
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "covis/core/error.h"
#include "covis/geometry/camera.h"
#include "covis/slam/system.h"
#include "covis/storage/map_file.h"
#include "covis/vocabulary/vocabulary.h"

namespace covis::app {

// The vocabulary named; with an empty name the default one, which lies in share/covis beside the installed command or
// in the source tree; null for "none".
Result<std::shared_ptr<const Vocabulary>> open_vocabulary(const std::string& name);

// The header of a map that this run makes.
storage::MapHeader map_header(const Camera& camera, const SystemOptions& options, const Vocabulary* vocabulary);

}  // namespace covis::app
