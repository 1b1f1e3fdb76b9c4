// SPDX-License-Identifier: Apache-2.0
// Reading image files.
#pragma once

#include <filesystem>
#include <string>

#include "covis/core/error.h"
#include "covis/core/image.h"

namespace covis::io {

// Reads images into memory that is used again: nothing of an image's size is allocated in the steady state, but by the
// decoders. Not for several threads at once.
class ImageReader {
 public:
  // Grey values; colour is converted on decoding (for JPEG: its luma as stored), 16 bits keep the upper 8. An error for
  // a file that is missing, cut short or no image.
  Result<void> grey(const std::filesystem::path& file, ImageU8& image);
  // Depth in metres: 16-bit files divided by `scale` (units a metre), 32-bit float files (TIFF) as they are. 0 where
  // there is none: what is negative or not finite is none.
  Result<void> depth(const std::filesystem::path& file, double scale, ImageF& depth);

 private:
  std::string bytes_;    // the bytes of the file
  Image<uint16_t> raw_;  // depth as stored
};

}  // namespace covis::io
