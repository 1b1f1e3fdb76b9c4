// SPDX-License-Identifier: Apache-2.0
#include "covis/tracking/point_counts.h"

#include "covis/core/reserve.h"

namespace covis {

// Reserves room in advance; its memory is used only when points come.
PointCounts::PointCounts() {
  constexpr size_t kPointSlots = 1 << 17, kPoints = 1 << 15;
  index_.reserve(kPointSlots);
  counts_.reserve(kPoints);
}

PointCount& PointCounts::at(MapPointId id) {
  uint32_t& index = at_slot(index_, id.slot);
  if (index == 0 || counts_[index - 1].point != id) {
    counts_.push_back({id, 0, 0});
    index = static_cast<uint32_t>(counts_.size());
  }
  return counts_[index - 1];
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
  std::vector<PointCount> counts = counts_;
  clear();
  return counts;
}

void PointCounts::clear() {
  for (const PointCount& count : counts_) index_[count.point.slot] = 0;
  counts_.clear();
}

}  // namespace covis
