// SPDX-License-Identifier: Apache-2.0
// Projects points into a key frame and merges what matches: after a key frame was made, and when a loop is closed.
// Source: Mur-Artal, Montiel, Tardós, "ORB-SLAM", T-RO 2015, sections VI-C and VII-C.
#pragma once

#include <vector>

#include "covis/map/shared_map.h"
#include "covis/matching/window_match.h"

namespace covis {

struct FuseOptions {
  double window = 3;        // pixels x scale
  bool keep_given = false;  // of two points the given one stays; else the one with more observations
  bool check_error = true;  // a match must lie within the 95 % bound of its reprojection error
};

// Keeps its work space between calls.
class PointFuser {
 public:
  // Points the target sees already are passed over. Returns the number of points merged or observations added.
  int fuse(SharedMap& map, KeyFrameId target, const std::vector<MapPointId>& points, const FuseOptions& options);

 private:
  WindowMatcher matcher_;
  std::vector<WindowQuery> queries_;
  std::vector<Descriptor> descriptors_;
  std::vector<MapPointId> candidates_;
  std::vector<int32_t> match_;
};

}  // namespace covis
