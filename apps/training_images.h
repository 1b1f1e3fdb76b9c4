// SPDX-License-Identifier: Apache-2.0
// The training images of a vocabulary: finds them, scales them, cuts them into pieces and extracts their descriptors.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "covis/core/error.h"
#include "covis/features/frontend.h"
#include "covis/vocabulary/train.h"

namespace covis::app {

// Returns the given files, and the images (jpg, png …) at any depth below the given folders, sorted by name. Folders
// called "depth" are skipped.
Result<std::vector<std::filesystem::path>> find_images(const std::vector<std::string>& files_or_folders);

struct ExtractionReport {
  std::vector<std::string> skipped;  // errors of images that could not be used
  bool stopped = false;
};

// Adds the descriptors of each image, in their order whatever the number of threads. An image is scaled to longest
// sides of 640, 1280 and 2560 pixels as far as it is larger, and each of these is cut into pieces of about 640 pixels;
// each piece counts as an image of its own. `progress` receives the number of images done; returning false stops.
ExtractionReport extract_images(const std::vector<std::filesystem::path>& files, const OrbOptions& options, int threads,
                                TrainingSet& set, const std::function<bool(size_t)>& progress);

}  // namespace covis::app
