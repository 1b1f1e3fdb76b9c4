// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "covis/map/map.h"

namespace covis::app {

// Returns the bytes of a PNG: the map's points and the path of its key frames from above, one plot a submap, as the
// cameras were held. `camera`: that of the map.
std::string picture_from_above(const Map& map, const Camera& camera, const std::string& title);

}  // namespace covis::app
