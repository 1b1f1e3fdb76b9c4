// SPDX-License-Identifier: Apache-2.0
// Locates frames that got no pose when they came, now that the map around them is there: backward in time, each from
// the one after it, as tracking does forward. A monocular camera gets its poses from before its map began in this way,
// and a camera that was lost those of the gap.
#pragma once

#include <optional>
#include <vector>

#include "covis/map/map_requests.h"
#include "covis/map/shared_map.h"
#include "covis/tracking/tracking_options.h"

namespace covis {

struct BacktrackSettings {
  Sensor sensor = Sensor::monocular;
  TrackerOptions options = {};
  int seed = 0;
};

struct Backtracked {
  std::vector<LocatedFrame> located;
  std::vector<UnlocatedFrame> left;  // those that were not found
};

// Looks for the poses of these frames (newest first). Reads the map in short read guards, and must not run while key
// frames are erased.
Backtracked backtrack(const SharedMap& map, const BacktrackSettings& settings,
                      const std::vector<UnlocatedFrame>& frames);

}  // namespace covis
