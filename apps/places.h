// SPDX-License-Identifier: Apache-2.0
// Shared by the commands that run the system: loading a vocabulary, and the header of a saved map.
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "covis/core/error.h"
#include "covis/vocabulary/vocabulary.h"

namespace covis::app {

// Loads the named vocabulary. An empty name selects the default one, in share/covis beside the installed command or in
// the source tree; "none" gives null.
Result<std::shared_ptr<const Vocabulary>> open_vocabulary(const std::string& name);

}  // namespace covis::app
