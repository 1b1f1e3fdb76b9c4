// SPDX-License-Identifier: Apache-2.0
// Frames without a pose that could not be located from where the camera was found after them (tracking/backtrack.h):
// what the map did not show when they came, it may show at the end.
#pragma once

#include <vector>

#include "covis/map/map_requests.h"
#include "covis/slam/snapshot.h"
#include "covis/tracking/relocaliser.h"

namespace covis {

class LateFrames {
 public:
  // Newest first; of many the oldest go.
  void keep(std::vector<UnlocatedFrame> frames);
  bool empty() const { return frames_.empty(); }
  // Locates them as single images, and forgets them. Each has to be within reach of the poses that are known
  // (path_reach.h), and a few in a row have to be found, as one alone may be at a look-alike.
  std::vector<LocatedFrame> locate(Relocaliser relocaliser, std::vector<PoseOfFrame> known);

 private:
  std::vector<UnlocatedFrame> frames_;
};

}  // namespace covis
