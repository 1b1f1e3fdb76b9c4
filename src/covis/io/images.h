// SPDX-License-Identifier: Apache-2.0
// Reading of image files.
#pragma once

#include <filesystem>
#include <string>

#include "covis/core/error.h"
#include "covis/core/image.h"

namespace covis::io {

// Reads images into reused memory: in the steady state only the decoders allocate memory of an image's size. Not
// thread-safe.
class ImageReader {
 public:
  // Reads grey values. Colour is converted on decoding (JPEG: the stored luma); of 16 bits the upper 8 are kept. Fails
  // for a file that is missing, truncated or no image.
  Result<void> grey(const std::filesystem::path& file, ImageU8& image);
  // Reads depth in metres: 16-bit files are divided by `scale` (units per metre), 32-bit float files (TIFF) are used as
  // they are. Negative and non-finite depths are stored as 0 (no measurement).
  Result<void> depth(const std::filesystem::path& file, double scale, ImageF& depth);

 private:
  std::string bytes_;    // contents of the file
  Image<uint16_t> raw_;  // depth as stored in the file
};

}  // namespace covis::io
