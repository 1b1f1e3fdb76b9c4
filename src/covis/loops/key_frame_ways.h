// SPDX-License-Identifier: Apache-2.0
// How far it is from one key frame to others along edges of the covisibility graph and of the spanning tree: a bound of
// the drift between them.
#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "covis/map/map.h"

namespace covis {

class KeyFrameWays {
 public:
  // The map's edges as they are now.
  explicit KeyFrameWays(const Map& map);

  // For each slot of the map the way from a key frame, in its submap's unit; infinite where none leads, or none of at
  // most this length. Method: Dijkstra, 1959.
  std::vector<double> from(KeyFrameId from, double longest = std::numeric_limits<double>::infinity()) const;

 private:
  struct Edge {
    uint32_t slot = 0;  // the other key frame's
    double length = 0;  // in the submap's unit
  };
  std::vector<Edge> edges_;      // in the order of the slots that they start at
  std::vector<uint32_t> first_;  // the first edge of each slot; one entry more than there are slots
};

}  // namespace covis
