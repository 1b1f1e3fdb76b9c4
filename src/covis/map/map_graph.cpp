// SPDX-License-Identifier: Apache-2.0
// Covisibility and the essential graph.
#include <algorithm>
#include <limits>

#include "covis/core/reserve.h"
#include "covis/map/map.h"

namespace covis {
namespace {

bool heavier(const Neighbour& a, const Neighbour& b) {
  return a.weight != b.weight ? a.weight > b.weight : a.key_frame < b.key_frame;
}

}  // namespace

void Map::add_weight(KeyFrameId a, KeyFrameId b, int delta) {
  const auto add = [&](KeyFrameId from, KeyFrameId to) {
    std::vector<Neighbour>& shared = key_frames_.at(from).shared;
    const auto at = std::ranges::lower_bound(shared, to, {}, &Neighbour::key_frame);
    if (at == shared.end() || at->key_frame != to) {
      const auto place = at - shared.begin();
      reserve_one_more(shared);
      shared.insert(shared.begin() + place, {to, delta});
    } else if ((at->weight += delta) == 0) {
      shared.erase(at);
    }
  };
  add(a, b);
  add(b, a);
}

int Map::weight(KeyFrameId a, KeyFrameId b) const {
  const KeyFrame* key_frame = find(a);
  if (!key_frame) return 0;
  const auto found = std::ranges::lower_bound(key_frame->shared, b, {}, &Neighbour::key_frame);
  return found != key_frame->shared.end() && found->key_frame == b ? found->weight : 0;
}

std::vector<Neighbour> Map::neighbours_above(KeyFrameId id, int least) const {
  std::vector<Neighbour> list;
  for (const Neighbour& n : at(id).shared) {
    if (n.weight >= least) list.push_back(n);
  }
  std::sort(list.begin(), list.end(), heavier);
  return list;
}

std::vector<Neighbour> Map::neighbours(KeyFrameId id) const {
  return best_neighbours(id, std::numeric_limits<int>::max());
}

std::vector<Neighbour> Map::best_neighbours(KeyFrameId id, int count) const {
  std::vector<Neighbour> list;
  best_neighbours(id, count, list);
  return list;
}

void Map::best_neighbours(KeyFrameId id, int count, std::vector<Neighbour>& list) const {
  const std::vector<Neighbour>& shared = at(id).shared;
  list.clear();
  for (const Neighbour& n : shared) {
    if (n.weight >= kCovisibilityThreshold) list.push_back(n);
  }
  if (list.empty() && !shared.empty()) list.push_back(*std::min_element(shared.begin(), shared.end(), heavier));
  const size_t kept = std::min(list.size(), static_cast<size_t>(count));
  std::partial_sort(list.begin(), list.begin() + static_cast<ptrdiff_t>(kept), list.end(), heavier);
  list.resize(kept);
}

int Map::tracked_points(KeyFrameId id, int min_observers) const {
  int count = 0;
  for (const MapPointId& point : at(id).points) {
    if (point.valid() && static_cast<int>(at(point).observations.size()) >= min_observers) ++count;
  }
  return count;
}

std::vector<std::pair<KeyFrameId, KeyFrameId>> Map::essential_graph() const {
  std::vector<std::pair<KeyFrameId, KeyFrameId>> edges;
  const auto add = [&](KeyFrameId a, KeyFrameId b) {
    if (at(a).serial < at(b).serial) std::swap(a, b);
    edges.emplace_back(a, b);
  };
  for (const KeyFrameId& id : key_frames()) {
    const KeyFrame& key_frame = at(id);
    if (key_frame.parent.valid()) add(id, key_frame.parent);
    for (const KeyFrameId& other : key_frame.loop_edges) add(id, other);
    for (const Neighbour& n : neighbours_above(id, kEssentialThreshold)) add(id, n.key_frame);
  }
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  return edges;
}

}  // namespace covis
