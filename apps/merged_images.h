// SPDX-License-Identifier: Apache-2.0
// The images that were kept with maps (covis run --keep-images), kept with the map that they become.
#pragma once

#include <string>
#include <vector>

#include "covis/core/error.h"
#include "covis/exchange/kept_images.h"
#include "covis/loops/map_merging.h"

namespace covis::app {

// Copies the images of the files' key frames beside each file to `kept`, under the serials that they have in the
// merged map. Returns how many key frames have one. What can't be copied is warned of.
Result<size_t> keep_merged_images(const std::vector<std::string>& files, const MergeReport& report, const Map& merged,
                                  const exchange::KeptImages& kept);

}  // namespace covis::app
