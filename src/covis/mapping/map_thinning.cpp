// SPDX-License-Identifier: Apache-2.0
#include "covis/mapping/map_thinning.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <queue>
#include <utility>

namespace covis {
namespace {

// How many key frames see each point, without those that were chosen to go.
class Observers {
 public:
  explicit Observers(const Map& map) : map_(map) {
    map.for_each_point([&](MapPointId id, const MapPoint& point) {
      left_.resize(id.slot + size_t{1});
      left_[id.slot] = static_cast<int>(point.observations.size());
    });
    map.for_each_key_frame([&](KeyFrameId id, const KeyFrame&) { gone_.resize(id.slot + size_t{1}); });
  }

  double cost_of(KeyFrameId id) const {
    double cost = 0;
    for (const MapPointId& point : map_.at(id).points) {
      if (point.valid() && left_[point.slot] > 0) cost += std::ldexp(1.0, 1 - left_[point.slot]);
    }
    return cost;
  }

  void let_go(KeyFrameId id) {
    gone_[id.slot] = true;
    for (const MapPointId& point : map_.at(id).points) {
      if (!point.valid() || left_[point.slot] == 0) continue;
      if (--left_[point.slot] == 1 && !is_held_by_one(map_.at(point))) left_[point.slot] = 0;
    }
  }

 private:
  // The rule is that of Map::erase_observation().
  bool is_held_by_one(const MapPoint& point) const {
    const auto last =
        std::ranges::find_if(point.observations, [&](const Observation& o) { return !gone_[o.key_frame.slot]; });
    return map_.at(last->key_frame).features->has_depth(static_cast<int>(last->feature));
  }

  const Map& map_;
  std::vector<int> left_;   // by slot of the point; 0: it would be gone
  std::vector<bool> gone_;  // by slot of the key frame
};

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

std::vector<KeyFrameId> expendable_key_frames(const Map& map, size_t count,
                                              const std::function<bool(KeyFrameId)>& may_go) {
  struct Entry {
    bool has_loop_edges;
    double cost;
    uint32_t slot;  // equal ones by slot
    auto operator<=>(const Entry&) const = default;
  };
  Observers observers(map);
  const auto entry_of = [&](KeyFrameId id) {
    return Entry{!map.at(id).loop_edges.empty(), observers.cost_of(id), id.slot};
  };
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
  map.for_each_key_frame([&](KeyFrameId id, const KeyFrame&) {
    if (!map.is_root(id) && may_go(id)) open.push(entry_of(id));
  });
  std::vector<KeyFrameId> chosen;
  while (chosen.size() < count && !open.empty()) {
    const KeyFrameId id = map.key_frame_in(open.top().slot);
    open.pop();
    // The others that go made it dearer since it was queued.
    const Entry now = entry_of(id);
    if (!open.empty() && now > open.top()) {
      open.push(now);
      continue;
    }
    chosen.push_back(id);
    observers.let_go(id);
  }
  return chosen;
}

std::vector<ThinnedKeyFrame> thin_map(Map& map, size_t key_frames) {
  std::vector<ThinnedKeyFrame> erased;
  const size_t count = std::max(map.key_frame_count(), key_frames) - key_frames;
  for (const KeyFrameId& id : expendable_key_frames(map, count, [](KeyFrameId) { return true; })) {
    const KeyFrame& key_frame = map.at(id);
    erased.push_back({key_frame.frame, key_frame.T_cw, key_frame.submap, key_frame.features});
    map.erase_key_frame(id);
  }
  for (const MapPointId& point : map.points()) map.refresh_point(point);
  return erased;
}

}  // namespace covis
