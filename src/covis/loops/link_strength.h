// SPDX-License-Identifier: Apache-2.0
// How firmly the key frames of a submap hang together in the order in which they were made: between each and the next,
// the points that key frames of both sides observe. Where these are few, the map hardly knows how the camera moved, and
// no share of the path bounds the drift.
#pragma once

#include <cstdint>
#include <vector>

#include "covis/map/map.h"

namespace covis {

class LinkStrength {
 public:
  LinkStrength(const Map& map, uint32_t submap);
  // The fewest points across any boundary between key frames of two serials; the greatest int between equal ones.
  int weakest(uint32_t serial_a, uint32_t serial_b) const;

 private:
  std::vector<uint32_t> serials_;  // serials of the submap's key frames, rising
  std::vector<int> across_;        // points across the boundary behind each
};

}  // namespace covis
