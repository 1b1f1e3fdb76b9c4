// SPDX-License-Identifier: Apache-2.0
// The images a vocabulary is trained from: found, scaled, cut into pieces, their descriptors extracted.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "covis/core/error.h"
#include "covis/features/frontend.h"
#include "covis/vocabulary/train.h"

namespace covis::app {

// Files as they are given, and what folders hold below them by name (jpg, png …) in the order of names; folders called
// "depth" are passed over.
Result<std::vector<std::filesystem::path>> find_images(const std::vector<std::string>& files_or_folders);

struct ExtractionReport {
  std::vector<std::string> skipped;  // a message for each image that could not be used
  bool stopped = false;
};

// Adds the descriptors of each image, in their order whatever the number of threads. An image is scaled to a longest
// side of 640, 1280 and 2560 pixels as far as it is larger, and each of these is cut into pieces of about 640 pixels;
// each piece counts as an image of its own. progress receives the number of images done; false stops.
ExtractionReport extract_images(const std::vector<std::filesystem::path>& files, const OrbOptions& options, int threads,
                                TrainingSet& set, const std::function<bool(size_t)>& progress);

}  // namespace covis::app
