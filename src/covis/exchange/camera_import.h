// SPDX-License-Identifier: Apache-2.0
// Cameras out of the files of other programs, of all kinds that can be read: those of io/camera_import.h and COLMAP's.
#pragma once

#include <filesystem>

#include "covis/core/error.h"
#include "covis/io/camera_import.h"

namespace covis::exchange {

// Recognises the kind by the file's content. Errors name the file, and for an unknown kind those that can be read.
Result<io::ImportedCamera> import_camera(const std::filesystem::path& file);

}  // namespace covis::exchange
