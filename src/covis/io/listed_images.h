// SPDX-License-Identifier: Apache-2.0
// Lists of stamped image files beside the images, as TUM RGB-D folders and OpenLORIS-Scene have them.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "covis/core/error.h"
#include "covis/core/time.h"
#include "covis/io/recording.h"

namespace covis::io {

struct ListedImage {
  Timestamp stamp = 0;
  std::string name;  // as written in the file
  std::string file;
};
using ListedRow = std::vector<ListedImage>;

// Reads rows of so many pairs "stamp file". Errors name file and line.
Result<std::vector<ListedRow>> read_listed_images(const std::filesystem::path& list, size_t pairs);

// Lists the frames of two lists with one image a row, paired by stamps. Notes how many images have no depth.
Result<std::vector<FrameFiles>> pair_with_depth(const std::filesystem::path& images,
                                                const std::filesystem::path& depths, Recording& recording);

}  // namespace covis::io
