// SPDX-License-Identifier: Apache-2.0
#include "covis/tracking/point_counts.h"

#include "covis/core/reserve.h"

namespace covis {

// Reserves room in advance; its memory is used only when points come.
PointCounts::PointCounts() {
  constexpr size_t kPointSlots = 1 << 17;
  counts_.reserve(kPointSlots);
  counted_.reserve(kPointSlots);
}

PointCount& PointCounts::at(MapPointId id) {
  PointCount& count = at_slot(counts_, id.slot);
  if (count.point != id) {
    count = {id, 0, 0};
    counted_.push_back(id.slot);
  }
  return count;
}

void PointCounts::add(std::span<const MapPointId> points, std::span<const uint8_t> in_view, const TrackedFrame& frame) {
  for (size_t k = 0; k < points.size(); ++k) {
    if (in_view[k]) ++at(points[k]).visible;
  }
  for (size_t i = 0; i < frame.source.size(); ++i) {
    if (frame.on_map(i)) ++at(frame.points[i]).found;
  }
}

std::vector<PointCount> PointCounts::take() {
  std::vector<PointCount> counts;
  for (const uint32_t slot : counted_) counts.push_back(counts_[slot]);
  clear();
  return counts;
}

void PointCounts::clear() {
  for (const uint32_t slot : counted_) counts_[slot] = {};
  counted_.clear();
}

}  // namespace covis
