// SPDX-License-Identifier: Apache-2.0
// Key frames: making, erasing, resolving; poses.
#include "covis/map/map.h"

#include <algorithm>
#include <cassert>

#include "covis/core/log.h"

namespace covis {
namespace {

void insert_sorted(std::vector<KeyFrameId>& list, KeyFrameId id) {
  const auto at = std::lower_bound(list.begin(), list.end(), id);
  if (at == list.end() || *at != id) list.insert(at, id);
}

void erase_sorted(std::vector<KeyFrameId>& list, KeyFrameId id) {
  const auto at = std::lower_bound(list.begin(), list.end(), id);
  if (at != list.end() && *at == id) list.erase(at);
}

}  // namespace

KeyFrameId Map::add_key_frame(int64_t frame, Timestamp stamp, const SE3& T_cw, FeaturesPtr features,
                              std::optional<uint32_t> submap) {
  if (submaps_.empty()) return begin_submap(frame, stamp, T_cw, std::move(features));
  return insert_key_frame(frame, stamp, T_cw, std::move(features), submap.value_or(submaps_.front().id));
}

KeyFrameId Map::insert_key_frame(int64_t frame, Timestamp stamp, const SE3& T_cw, FeaturesPtr features,
                                 uint32_t submap) {
  if (!T_cw.all_finite()) {
    ++refused_non_finite_;
    log(LogLevel::error, "a key frame with a pose that is not finite was refused");
    return {};
  }
  KeyFrame key_frame;
  key_frame.serial = next_serial_++;
  key_frame.submap = submap;
  key_frame.frame = frame;
  key_frame.stamp = stamp;
  key_frame.T_cw = T_cw;
  key_frame.points.resize(static_cast<size_t>(features->size()));
  key_frame.features = std::move(features);
  ++submap_at(submap).key_frames;
  return key_frames_.insert(std::move(key_frame));
}

void Map::attach_to_tree(KeyFrameId id) {
  KeyFrame& key_frame = key_frames_.at(id);
  if (is_root(id) || key_frame.parent.valid()) return;
  KeyFrameId parent;
  int best = 0;
  uint32_t best_serial = 0;
  for (const Neighbour& n : key_frame.shared) {
    const uint32_t serial = at(n.key_frame).serial;
    if (serial >= key_frame.serial) continue;  // a parent is older: the tree can't close on itself
    if (n.weight > best || (n.weight == best && serial < best_serial)) {
      best = n.weight;
      best_serial = serial;
      parent = n.key_frame;
    }
  }
  if (!parent.valid()) {
    uint32_t newest_serial = 0;
    for_each_key_frame([&](KeyFrameId other, const KeyFrame& k) {
      if (k.submap == key_frame.submap && k.serial < key_frame.serial &&
          (!parent.valid() || k.serial > newest_serial)) {
        parent = other;
        newest_serial = k.serial;
      }
    });
  }
  assert(parent.valid());
  key_frame.parent = parent;
  insert_sorted(key_frames_.at(parent).children, id);
}

bool Map::erase_key_frame(KeyFrameId id) {
  KeyFrame* key_frame = key_frames_.find(id);
  if (!key_frame || is_root(id)) return false;
  const std::vector<MapPointId> points = key_frame->points;
  for (const MapPointId& point : points) {
    if (point.valid()) erase_observation(point, id);
  }
  reattach_children(id);
  const KeyFrameId parent = key_frame->parent;
  erase_sorted(key_frames_.at(parent).children, id);
  for (const KeyFrameId& other : key_frame->loop_edges) erase_sorted(key_frames_.at(other).loop_edges, id);
  if (key_frame->words) database_.erase(id, *key_frame->words);
  --submap_at(key_frame->submap).key_frames;
  erased_frames_[id] = {parent, key_frame->T_cw * at(parent).T_cw.inverse(), key_frame->scale, at(parent).scale,
                        ++erasures_};
  return key_frames_.erase(id);
}

// algorithms.md §2: repeatedly the (child, candidate) pair of greatest weight, candidates being the erased frame's
// parent and the children already re-attached; children without any pair go to the parent.
void Map::reattach_children(KeyFrameId id) {
  KeyFrame& erased = key_frames_.at(id);
  std::vector<KeyFrameId> open = std::move(erased.children);
  erased.children.clear();
  std::vector<KeyFrameId> candidates{erased.parent};
  while (!open.empty()) {
    KeyFrameId child, parent;
    int best = 0;
    for (const KeyFrameId& c : open) {
      for (const KeyFrameId& p : candidates) {
        const int w = weight(c, p);
        if (w > best) {
          best = w;
          child = c;
          parent = p;
        }
      }
    }
    if (best == 0) break;
    key_frames_.at(child).parent = parent;
    insert_sorted(key_frames_.at(parent).children, child);
    open.erase(std::find(open.begin(), open.end(), child));
    candidates.push_back(child);
  }
  for (const KeyFrameId& child : open) {
    key_frames_.at(child).parent = erased.parent;
    insert_sorted(key_frames_.at(erased.parent).children, child);
  }
}

bool Map::set_pose(KeyFrameId id, const SE3& T_cw) {
  KeyFrame* key_frame = key_frames_.find(id);
  if (!key_frame) return false;
  if (!T_cw.all_finite()) {
    ++refused_non_finite_;
    log(LogLevel::error, "a pose that is not finite was refused");
    return false;
  }
  key_frame->T_cw = T_cw;
  return true;
}

void Map::set_words(KeyFrameId id, std::shared_ptr<const Words> words) {
  KeyFrame& key_frame = key_frames_.at(id);
  assert(!key_frame.words && words);
  database_.add(id, *words);
  key_frame.words = std::move(words);
}

bool Map::set_features(KeyFrameId id, FeaturesPtr features) {
  KeyFrame* key_frame = key_frames_.find(id);
  if (!key_frame) return false;
  assert(features->size() == key_frame->features->size());
  key_frame->features = std::move(features);
  return true;
}

bool Map::set_colours(KeyFrameId id, ColoursPtr colours) {
  const KeyFrame* key_frame = find(id);
  if (!key_frame) return false;
  assert(colours && colours->size() == key_frame->points.size());
  key_frames_.at(id).colours = std::move(colours);
  return true;
}

bool Map::correct_pose(KeyFrameId id, const SE3& T_cw, double growth) {
  if (!set_pose(id, T_cw)) return false;
  key_frames_.at(id).scale *= growth;
  count_move();
  return true;
}

void Map::add_loop_edge(KeyFrameId a, KeyFrameId b) {
  assert(a != b && at(a).submap == at(b).submap);
  insert_sorted(key_frames_.at(a).loop_edges, b);
  insert_sorted(key_frames_.at(b).loop_edges, a);
}

std::vector<KeyFrameId> Map::key_frames() const {
  std::vector<KeyFrameId> ids;
  ids.reserve(key_frames_.size());
  for_each_key_frame([&](KeyFrameId id, const KeyFrame&) { ids.push_back(id); });
  std::sort(ids.begin(), ids.end(), [&](KeyFrameId a, KeyFrameId b) { return at(a).serial < at(b).serial; });
  return ids;
}

std::optional<Map::Resolved> Map::resolve(KeyFrameId id) const {
  // Translations are kept in the unit of the last key frame of the chain, and brought to the next one's on the way.
  SE3 T_ar;
  double scale = 1;  // the asked one's now, as if it lived
  bool first = true;
  while (!find(id)) {
    const auto erased = erased_frames_.find(id);
    if (erased == erased_frames_.end()) return std::nullopt;
    const Ancestor& a = erased->second;
    if (first) scale = a.scale;
    first = false;
    T_ar = T_ar * a.T_cp;
    id = a.parent;
    const auto next = erased_frames_.find(id);
    const double now = find(id) ? at(id).scale : next == erased_frames_.end() ? a.parent_scale : next->second.scale;
    const double growth = now / a.parent_scale;
    T_ar = SE3(T_ar.R(), Eigen::Vector3d(growth * T_ar.t()));
    scale *= growth;
  }
  return Resolved{id, T_ar, first ? at(id).scale : scale};
}

// The parent of an erased key frame lives then, so that chains lead to later erasures: without its head the rest of one
// is whole.
void Map::forget_erased(uint64_t count) {
  std::erase_if(erased_frames_, [&](const auto& entry) { return entry.second.erasure <= count; });
}

}  // namespace covis
