// SPDX-License-Identifier: Apache-2.0
// The submaps of a map: beginning, joining, erasing.
#include <algorithm>
#include <cassert>

#include "covis/map/map.h"

namespace covis {
namespace {

template <class Submaps>
auto find_submap(Submaps& submaps, uint32_t id) {
  const auto at = std::lower_bound(submaps.begin(), submaps.end(), id,
                                   [](const Submap& submap, uint32_t wanted) { return submap.id < wanted; });
  return at != submaps.end() && at->id == id ? at : submaps.end();
}

}  // namespace

const Submap* Map::submap(uint32_t id) const {
  const auto at = find_submap(submaps_, id);
  return at == submaps_.end() ? nullptr : &*at;
}

std::vector<KeyFrameId> Map::key_frames(uint32_t submap) const {
  std::vector<KeyFrameId> ids = key_frames();
  std::erase_if(ids, [&](KeyFrameId id) { return at(id).submap != submap; });
  return ids;
}

Submap& Map::submap_at(uint32_t id) {
  const auto at = find_submap(submaps_, id);
  assert(at != submaps_.end());
  return *at;
}

bool Map::is_root(KeyFrameId id) const {
  const KeyFrame* key_frame = find(id);
  const Submap* of = key_frame ? submap(key_frame->submap) : nullptr;
  return of && of->root == id;
}

KeyFrameId Map::begin_submap(int64_t frame, Timestamp stamp, const SE3& T_cw, FeaturesPtr features) {
  submaps_.push_back({next_submap_, {}, 0});
  const KeyFrameId id = insert_key_frame(frame, stamp, T_cw, std::move(features), next_submap_);
  if (!id.valid()) {
    submaps_.pop_back();
    return id;
  }
  submaps_.back().root = id;
  ++next_submap_;
  return id;
}

// Makes `id` the root of its tree: the links on the way up from it are reversed.
void Map::reroot_tree(KeyFrameId id) {
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

bool Map::join_submaps(KeyFrameId child, KeyFrameId parent, const Sim3& S) {
  if (!find(child) || !find(parent) || at(child).submap == at(parent).submap || !S.all_finite()) return false;
  const uint32_t from = at(child).submap, to = at(parent).submap;
  const Sim3 back = S.inverse();
  for_each_point([&](MapPointId id, const MapPoint& seen) {
    if (at(seen.reference).submap != from) return;
    MapPoint& point = points_.at(id);
    point.position_w = S * point.position_w;
    point.normal_w = S.R() * point.normal_w;
    point.d_min *= static_cast<float>(S.scale());
    point.d_max *= static_cast<float>(S.scale());
  });
  for_each_key_frame([&](KeyFrameId id, const KeyFrame& seen) {
    if (seen.submap != from) return;
    KeyFrame& key_frame = key_frames_.at(id);
    key_frame.T_cw = (Sim3(key_frame.T_cw) * back).as_pose();
    key_frame.scale *= S.scale();
    key_frame.submap = to;
  });
  reroot_tree(child);
  key_frames_.at(child).parent = parent;
  std::vector<KeyFrameId>& children = key_frames_.at(parent).children;
  children.insert(std::lower_bound(children.begin(), children.end(), child), child);
  submap_at(to).key_frames += submap_at(from).key_frames;
  submaps_.erase(find_submap(submaps_, from));
  ++moves_;
  return true;
}

bool Map::erase_submap(uint32_t submap_id) {
  if (!submap(submap_id)) return false;
  std::vector<MapPointId> points;
  for_each_point([&](MapPointId id, const MapPoint& point) {
    if (at(point.reference).submap == submap_id) points.push_back(id);
  });
  std::vector<KeyFrameId> frames;
  for_each_key_frame([&](KeyFrameId id, const KeyFrame& key_frame) {
    if (key_frame.submap == submap_id) frames.push_back(id);
  });
  // Links lead from one of these to another only.
  for (const MapPointId& id : points) points_.erase(id);
  for (const KeyFrameId& id : frames) {
    if (const auto& words = at(id).words) database_.erase(id, *words);
    key_frames_.erase(id);
  }
  submaps_.erase(find_submap(submaps_, submap_id));
  return true;
}

}  // namespace covis
