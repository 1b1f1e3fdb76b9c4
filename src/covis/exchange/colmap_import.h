// SPDX-License-Identifier: Apache-2.0
// A map to localise in, made of a COLMAP model and its images: each image becomes a key frame at the pose that COLMAP
// gave it. COLMAP's points are not used, for they have no ORB descriptors: points are triangulated anew from ORB
// features of images that COLMAP found to see the same, and fused as those of a run are. Poses stay as they are.
#pragma once

#include <filesystem>

#include "covis/core/error.h"
#include "covis/exchange/colmap_model.h"
#include "covis/features/frontend.h"
#include "covis/map/shared_map.h"

namespace covis::exchange {

// Fills an empty map, in COLMAP's world and unit. An image that can't be read, is of another size than the camera's or
// shares no points with those before is left out with a warning. Error: fewer than two images are left.
Result<void> import_colmap(const ColmapModel& model, const std::filesystem::path& images, const OrbOptions& options,
                           SharedMap& map);

}  // namespace covis::exchange
