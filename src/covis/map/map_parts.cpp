// SPDX-License-Identifier: Apache-2.0
// The parts of a map: beginning, joining, erasing.
#include <algorithm>
#include <cassert>

#include "covis/map/map.h"

namespace covis {
namespace {

template <class Parts>
auto find_part(Parts& parts, uint32_t number) {
  const auto at = std::lower_bound(parts.begin(), parts.end(), number,
                                   [](const MapPart& part, uint32_t wanted) { return part.number < wanted; });
  return at != parts.end() && at->number == number ? at : parts.end();
}

}  // namespace

const MapPart* Map::part(uint32_t number) const {
  const auto at = find_part(parts_, number);
  return at == parts_.end() ? nullptr : &*at;
}

std::vector<KeyFrameId> Map::key_frames(uint32_t part) const {
  std::vector<KeyFrameId> ids = key_frames();
  std::erase_if(ids, [&](KeyFrameId id) { return at(id).part != part; });
  return ids;
}

MapPart& Map::part_at(uint32_t number) {
  const auto at = find_part(parts_, number);
  assert(at != parts_.end());
  return *at;
}

bool Map::is_root(KeyFrameId id) const {
  const KeyFrame* key_frame = find(id);
  const MapPart* of = key_frame ? part(key_frame->part) : nullptr;
  return of && of->root == id;
}

KeyFrameId Map::begin_part(int64_t frame, Timestamp stamp, const SE3& T_cw, FeaturesPtr features) {
  parts_.push_back({next_part_, {}, 0});
  const KeyFrameId id = insert_key_frame(frame, stamp, T_cw, std::move(features), next_part_);
  if (!id.valid()) {
    parts_.pop_back();
    return id;
  }
  parts_.back().root = id;
  ++next_part_;
  return id;
}

// Turns the links on the way from `id` up to the root of its tree round.
void Map::hang_tree_on(KeyFrameId id) {
  KeyFrameId below;
  while (id.valid()) {
    KeyFrame& key_frame = key_frames_.at(id);
    const KeyFrameId above = key_frame.parent;
    key_frame.parent = below;
    std::vector<KeyFrameId>& children = key_frame.children;
    if (below.valid()) std::erase(children, below);
    if (above.valid()) children.insert(std::lower_bound(children.begin(), children.end(), above), above);
    below = id;
    id = above;
  }
}

bool Map::join_parts(KeyFrameId child, KeyFrameId parent, const Sim3& S) {
  if (!find(child) || !find(parent) || at(child).part == at(parent).part || !S.all_finite()) return false;
  const uint32_t from = at(child).part, to = at(parent).part;
  const Sim3 back = S.inverse();
  for_each_point([&](MapPointId id, const MapPoint& seen) {
    if (at(seen.reference).part != from) return;
    MapPoint& point = points_.at(id);
    point.position_w = S * point.position_w;
    point.normal_w = S.R() * point.normal_w;
    point.d_min *= static_cast<float>(S.scale());
    point.d_max *= static_cast<float>(S.scale());
  });
  for_each_key_frame([&](KeyFrameId id, const KeyFrame& seen) {
    if (seen.part != from) return;
    KeyFrame& key_frame = key_frames_.at(id);
    key_frame.T_cw = (Sim3(key_frame.T_cw) * back).as_pose();
    key_frame.scale *= S.scale();
    key_frame.part = to;
  });
  hang_tree_on(child);
  key_frames_.at(child).parent = parent;
  std::vector<KeyFrameId>& children = key_frames_.at(parent).children;
  children.insert(std::lower_bound(children.begin(), children.end(), child), child);
  part_at(to).key_frames += part_at(from).key_frames;
  parts_.erase(find_part(parts_, from));
  ++moves_;
  return true;
}

bool Map::erase_part(uint32_t number) {
  if (!part(number)) return false;
  std::vector<MapPointId> points;
  for_each_point([&](MapPointId id, const MapPoint& point) {
    if (at(point.reference).part == number) points.push_back(id);
  });
  std::vector<KeyFrameId> frames;
  for_each_key_frame([&](KeyFrameId id, const KeyFrame& key_frame) {
    if (key_frame.part == number) frames.push_back(id);
  });
  // Links lead from one of these to another only.
  for (const MapPointId& id : points) points_.erase(id);
  for (const KeyFrameId& id : frames) {
    if (const auto& words = at(id).words) database_.erase(id, *words);
    key_frames_.erase(id);
  }
  parts_.erase(find_part(parts_, number));
  return true;
}

}  // namespace covis
