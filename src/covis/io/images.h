// SPDX-License-Identifier: Apache-2.0
// Reading and writing image files.
#pragma once

#include <filesystem>

#include "covis/core/error.h"
#include "covis/core/image.h"

namespace covis::io {

// Grey values; colour is converted on decoding. An error for a file that is missing, cut short or no image.
Result<void> read_grey(const std::filesystem::path& file, ImageU8& image);
// Depth in metres: 16-bit files divided by `scale` (units a metre), 32-bit float files as they are.
Result<void> read_depth(const std::filesystem::path& file, double scale, ImageF& depth);

}  // namespace covis::io
