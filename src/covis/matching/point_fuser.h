// SPDX-License-Identifier: Apache-2.0
// Projects points into a key frame and merges what matches: after a key frame was made, and when a loop is closed.
// Source: Mur-Artal, Montiel, Tardós, "ORB-SLAM", T-RO 2015, sections VI-C and VII-C.
#pragma once

#include <vector>

#include "covis/map/shared_map.h"
#include "covis/matching/projection_match.h"

namespace covis {

// Which of two points that turn out to be one stays.
enum class FuseKeep { more_observed, given };

struct FuseOptions {
  double window = 3;  // pixels x scale
  FuseKeep keep = FuseKeep::more_observed;
  MatchError error = MatchError::within_bound;
};

// Keeps its work space between calls.
class PointFuser {
 public:
  // Points the target sees already are passed over. Returns the number of points merged or observations added.
  int fuse(SharedMap& map, KeyFrameId target, const std::vector<MapPointId>& points, const FuseOptions& options);

 private:
  PointSet candidates_;
  ProjectionMatcher matcher_;
};

}  // namespace covis
