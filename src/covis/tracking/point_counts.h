// SPDX-License-Identifier: Apache-2.0
// Counts, for each map point, the frames that had it in view and the frames that matched it, until they are reported to
// mapping.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "covis/map/map_requests.h"
#include "covis/tracking/tracked_frame.h"

namespace covis {

class PointCounts {
 public:
  PointCounts();
  // Counts one frame: the points of its local map, a flag for each that was in view, and its matches.
  void add(std::span<const MapPointId> points, std::span<const uint8_t> in_view, const TrackedFrame& frame);
  // Returns all counts since the last call, in the order in which points were first counted.
  std::vector<PointCount> take();
  void clear();

 private:
  PointCount& at(MapPointId id);

  std::vector<uint32_t> index_;     // by point slot: 1 + index of the count of its newest point, or 0
  std::vector<PointCount> counts_;  // in the order in which points were first counted
};

}  // namespace covis
