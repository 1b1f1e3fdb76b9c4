// SPDX-License-Identifier: Apache-2.0
// Counts, for each map point, the frames that had it in view and the frames that matched it, until mapping is told.
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
  // One frame: the points of its local map, which of them were in view, and its matches.
  void add(std::span<const MapPointId> points, std::span<const uint8_t> in_view, const TrackedFrame& frame);
  // All counts since the last call, by the order in which points were first counted.
  std::vector<PointCount> take();
  void clear();

 private:
  PointCount& at(MapPointId id);

  std::vector<PointCount> counts_;  // by point slot
  std::vector<uint32_t> counted_;   // slots with a count
};

}  // namespace covis
