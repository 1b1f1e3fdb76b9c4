// SPDX-License-Identifier: Apache-2.0
#include "covis/loops/key_frame_ways.h"

#include <functional>
#include <queue>
#include <utility>

namespace covis {

KeyFrameWays::KeyFrameWays(const Map& map) {
  std::vector<Eigen::Vector3d> centre;
  map.for_each_key_frame([&](KeyFrameId id, const KeyFrame& key_frame) {
    centre.resize(id.slot + size_t{1});
    centre[id.slot] = key_frame.T_cw.centre();
  });
  map.for_each_key_frame([&](KeyFrameId id, const KeyFrame& key_frame) {
    const auto add = [&](KeyFrameId other) {
      edges_.push_back({other.slot, (centre[other.slot] - centre[id.slot]).norm()});
    };
    first_.resize(id.slot + size_t{1}, static_cast<uint32_t>(edges_.size()));
    for (const Neighbour& n : key_frame.shared) {
      if (n.weight >= kCovisibilityThreshold) add(n.key_frame);
    }
    if (key_frame.parent.valid()) add(key_frame.parent);
    for (const KeyFrameId& child : key_frame.children) add(child);
  });
  first_.push_back(static_cast<uint32_t>(edges_.size()));
}

std::vector<double> KeyFrameWays::from(KeyFrameId from, double longest) const {
  std::vector<double> way(first_.size() - 1, std::numeric_limits<double>::infinity());
  using Step = std::pair<double, uint32_t>;  // length of the way, slot
  std::priority_queue<Step, std::vector<Step>, std::greater<>> open;
  const auto reach = [&](uint32_t slot, double length) {
    if (length >= way[slot] || length > longest) return;
    way[slot] = length;
    open.emplace(length, slot);
  };
  reach(from.slot, 0);
  while (!open.empty()) {
    const auto [length, slot] = open.top();
    open.pop();
    if (length > way[slot]) continue;
    for (uint32_t k = first_[slot]; k < first_[slot + size_t{1}]; ++k) reach(edges_[k].slot, length + edges_[k].length);
  }
  return way;
}

}  // namespace covis
