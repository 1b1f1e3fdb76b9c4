// SPDX-License-Identifier: Apache-2.0
// Stamps of images in a folder that lists none beside their names.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "covis/core/error.h"
#include "covis/core/time.h"

namespace covis::io {

// Finds the stamps of a folder's images: in times.txt, timestamps.txt or stamps.txt of the recording or of the images'
// folder (see read_stamps()), else in names that are numbers of ten digits or more, else by the rate in Hz (0: 30).
// Notes when names that look like stamps are not used.
Result<std::vector<Timestamp>> stamps_of_images(const std::filesystem::path& recording,
                                                const std::filesystem::path& folder,
                                                const std::vector<std::filesystem::path>& images, double rate,
                                                std::vector<std::string>& notes);

}  // namespace covis::io
