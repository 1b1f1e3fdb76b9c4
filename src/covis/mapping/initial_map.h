// SPDX-License-Identifier: Apache-2.0
// The first two key frames and points of a monocular submap.
// Source: Mur-Artal, Montiel, Tardós, "ORB-SLAM", T-RO 2015, section IV, step 5.
#pragma once

#include <optional>

#include "covis/map/map_requests.h"
#include "covis/map/shared_map.h"
#include "covis/mapping/recent_points.h"
#include "covis/optimization/bundle_adjustment.h"

namespace covis {

struct InitialMap {
  KeyFrameId first, second;
  int points = 0;
};

// Adjusts both views and their points, scales them to a median depth of 1 and makes them a submap. Nothing,
// and the map is left alone, when too few points survive the adjustment or they lie behind the first camera.
std::optional<InitialMap> make_initial_map(SharedMap& map, const InitialMapRequest& request, BundleAdjuster& adjuster,
                                           RecentPoints& recent);

}  // namespace covis
