// SPDX-License-Identifier: Apache-2.0
#include "covis/mapping/map_thinning.h"

#include <cmath>
#include <functional>
#include <queue>
#include <utility>

namespace covis {
namespace {

double cost_of(const Map& map, KeyFrameId id) {
  double cost = 0;
  for (const MapPointId& point : map.at(id).points) {
    if (point.valid()) cost += std::ldexp(1.0, 1 - static_cast<int>(map.at(point).observations.size()));
  }
  return cost;
}

}  // namespace

void thin_points(Map& map, size_t points) {
  std::vector<int> seen;  // by slot of the key frame: the points it sees
  map.for_each_key_frame([&](KeyFrameId id, const KeyFrame& key_frame) {
    seen.resize(id.slot + size_t{1});
    for (const MapPointId& point : key_frame.points) seen[id.slot] += point.valid();
  });
  const auto cost = [&](const MapPoint& point) {
    double sum = 0;
    for (const Observation& o : point.observations) sum += 1.0 / seen[o.key_frame.slot];
    return sum * point.found / point.visible;
  };
  using Entry = std::pair<double, MapPointId>;  // equal ones by handle
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
  map.for_each_point([&](MapPointId id, const MapPoint& point) { open.emplace(cost(point), id); });
  while (map.point_count() > points) {
    const MapPointId id = open.top().second;
    open.pop();
    const double now = cost(map.at(id));  // the others that went can but have made it dearer
    if (!open.empty() && now > open.top().first) {
      open.emplace(now, id);
      continue;
    }
    for (const Observation& o : map.at(id).observations) --seen[o.key_frame.slot];
    map.erase_point(id);
  }
}

std::vector<ThinnedKeyFrame> thin_map(Map& map, size_t key_frames) {
  using Entry = std::pair<double, uint32_t>;  // cost, slot: equal ones by slot
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
  map.for_each_key_frame([&](KeyFrameId id, const KeyFrame&) {
    if (!map.is_root(id)) open.emplace(cost_of(map, id), id.slot);
  });
  std::vector<ThinnedKeyFrame> erased;
  while (map.key_frame_count() > key_frames && !open.empty()) {
    const KeyFrameId id = map.key_frame_in(open.top().second);
    open.pop();
    // The others that went made it dearer since it was queued.
    const double now = cost_of(map, id);
    if (!open.empty() && now > open.top().first) {
      open.emplace(now, id.slot);
      continue;
    }
    const KeyFrame& key_frame = map.at(id);
    erased.push_back({key_frame.frame, key_frame.T_cw, key_frame.submap, key_frame.features});
    map.erase_key_frame(id);
  }
  for (const MapPointId& point : map.points()) map.refresh_point(point);
  return erased;
}

}  // namespace covis
