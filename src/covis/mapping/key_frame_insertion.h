// SPDX-License-Identifier: Apache-2.0
// Makes a frame a key frame of the map, with what tracking matched in it.
// Source: Mur-Artal, Montiel, Tardós, "ORB-SLAM", T-RO 2015, section VI-A; new points by depth: Mur-Artal and Tardós,
// "ORB-SLAM2", T-RO 2017, III-C.
#pragma once

#include "covis/map/map_requests.h"
#include "covis/map/shared_map.h"
#include "covis/mapping/recent_points.h"

namespace covis {

// The new key frame, in the submap of its reference or, without one, in a submap of its own. Invalid when the reference
// is gone or the pose is not finite. New points are added to `recent`.
KeyFrameId insert_key_frame(SharedMap& map, const KeyFrameRequest& request, RecentPoints& recent);

}  // namespace covis
