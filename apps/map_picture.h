// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "covis/eval/plot.h"
#include "covis/map/map.h"

namespace covis::app {

// The map's points and the path of its key frames from above, one plot a submap, as the cameras were held. `camera`:
// that of the map.
std::vector<Plot> plots_from_above(const Map& map, const Camera& camera, const std::string& title);

}  // namespace covis::app
