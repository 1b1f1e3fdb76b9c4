// SPDX-License-Identifier: Apache-2.0
#include "covis/loops/link_strength.h"

#include <algorithm>
#include <limits>

namespace covis {

LinkStrength::LinkStrength(const Map& map, uint32_t submap) {
  std::vector<size_t> order;  // by slot
  for (const KeyFrameId& id : map.key_frames(submap)) {
    if (order.size() <= id.slot) order.resize(id.slot + size_t{1});
    order[id.slot] = serials_.size();
    serials_.push_back(map.at(id).serial);
  }
  // Each point adds one from its first observer on, and takes it away from its last one on.
  std::vector<int> change(serials_.size() + 1, 0);
  map.for_each_point([&](MapPointId, const MapPoint& point) {
    if (map.at(point.reference).submap != submap) return;
    size_t first = serials_.size(), last = 0;
    for (const Observation& o : point.observations) {
      first = std::min(first, order[o.key_frame.slot]);
      last = std::max(last, order[o.key_frame.slot]);
    }
    ++change[first];
    --change[last];
  });
  int open = 0;
  for (size_t k = 0; k < serials_.size(); ++k) across_.push_back(open += change[k]);
}

int LinkStrength::weakest(uint32_t serial_a, uint32_t serial_b) const {
  const auto [low, high] = std::minmax(serial_a, serial_b);
  const auto first = std::lower_bound(serials_.begin(), serials_.end(), low) - serials_.begin();
  const auto last = std::lower_bound(serials_.begin(), serials_.end(), high) - serials_.begin();
  if (first == last) return std::numeric_limits<int>::max();
  return *std::min_element(across_.begin() + first, across_.begin() + last);
}

}  // namespace covis
