// SPDX-License-Identifier: Apache-2.0
#include "covis/mapping/map_area.h"

#include <algorithm>
#include <set>
#include <utility>
#include <vector>

#include "covis/map/map_state.h"

namespace covis {
namespace {

// Makes a key frame the root of its submap: the edges of the spanning tree on the way up are turned around.
void make_root(MapState& state, uint32_t key_frame) {
  uint32_t below = MapState::kNone;
  while (key_frame != MapState::kNone) {
    const uint32_t above = std::exchange(state.key_frames[key_frame].parent, below);
    below = std::exchange(key_frame, above);
  }
}

}  // namespace

Result<Map> part_of(const Map& map, const std::function<bool(const Eigen::Vector3d&)>& inside) {
  MapState state = map.state();
  std::vector<bool> stays;
  for (const KeyFrameState& key_frame : state.key_frames) stays.push_back(inside(key_frame.T_cw.centre()));
  if (std::find(stays.begin(), stays.end(), true) == stays.end()) return fail("no key frame lies there");
  // A root that goes hands its submap to the oldest key frame that stays.
  std::set<uint32_t> rooted;
  const std::vector<KeyFrameId> ids = map.key_frames();  // in the order of the state
  for (uint32_t k = 0; k < ids.size(); ++k) {
    if (stays[k] && rooted.insert(map.at(ids[k]).submap).second) make_root(state, k);
  }
  const auto root = std::find_if(state.key_frames.begin(), state.key_frames.end(),
                                 [](const KeyFrameState& k) { return k.parent == MapState::kNone; });
  state.root = static_cast<uint32_t>(root - state.key_frames.begin());
  auto part = Map::from_state(std::move(state));
  if (!part) return part;
  const std::vector<KeyFrameId> made = part->key_frames();
  for (size_t k = 0; k < made.size(); ++k) {
    if (stays[k] || !part->find(made[k])) continue;
    if (part->is_root(made[k])) {
      part->erase_submap(part->at(made[k]).submap);
    } else {
      part->erase_key_frame(made[k]);
    }
  }
  for (const MapPointId& point : part->points()) part->refresh_point(point);
  return part;
}

}  // namespace covis
