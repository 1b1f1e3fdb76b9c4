// SPDX-License-Identifier: Apache-2.0
// Projects points into a key frame and merges what matches: after a key frame was made, and when a loop is closed.
// Source: Mur-Artal, Montiel, Tardós, "ORB-SLAM", T-RO 2015, sections VI-C and VII-C.
#pragma once

#include <vector>

#include "covis/map/shared_map.h"
#include "covis/matching/fuse_memory.h"
#include "covis/matching/projection_match.h"

namespace covis {

// Which of two points that turn out to be one stays.
enum class FuseKeep { more_observed, given };

struct FuseOptions {
  double window = 3;  // pixels x scale: search around a projected point
  FuseKeep keep = FuseKeep::more_observed;
  MatchError error = MatchError::within_bound;
};

// Keeps its work space between calls.
class PointFuser {
 public:
  // Looks for the points in the target and writes what it finds to the map: a feature without a point gets an
  // observation, and of two points one replaces the other. Reads and writes under guards of its own, and matches
  // without one. Points that the target observes already, and stale ones, are passed over; a stale target has none.
  // Returns the number of points merged and observations added. Points that `memory` has are not searched again, and
  // those that are not in view or look like no feature there are added to it.
  int fuse(SharedMap& map, KeyFrameId target, const std::vector<MapPointId>& points, const FuseOptions& options,
           FuseMemory* memory = nullptr);

 private:
  PointSet candidates_;
  ProjectionMatcher matcher_;
};

}  // namespace covis
