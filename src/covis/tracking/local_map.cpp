// SPDX-License-Identifier: Apache-2.0
#include "covis/tracking/local_map.h"

#include <algorithm>

#include "covis/core/reserve.h"

namespace covis {
namespace {

constexpr int kBestNeighbours = 10;  // neighbours of each key frame of K1 that join K2

// The share of frames that match a point they have in view. A point seen by few frames is taken for one of the usual
// ones, as if some frames more had seen it.
float expected_match_ratio(const MapPoint& point) {
  constexpr float kUsual = 0.6f, kFrames = 4;
  const float ratio =
      (static_cast<float>(point.found) + kUsual * kFrames) / (static_cast<float>(point.visible) + kFrames);
  return std::min(ratio, 1.0f);
}

}  // namespace

// Reserves room in advance; its memory is used only when points and key frames come.
LocalMap::LocalMap() {
  constexpr size_t kPoints = 1 << 14, kPointSlots = 1 << 17, kKeyFrameSlots = 1 << 12;
  points.reserve(kPoints);
  match_ratio.reserve(kPoints);
  point_seen_.reserve(kPointSlots);
  new_.reserve(kPointSlots);
  key_frame_seen_.reserve(kKeyFrameSlots);
  votes_.reserve(kKeyFrameSlots);
  voted_.reserve(kKeyFrameSlots);
  key_frames.reserve(kKeyFrameSlots);
  neighbours_.reserve(kKeyFrameSlots);
}

void LocalMap::clear() {
  ++epoch_;
  points.clear();
  match_ratio.clear();
  key_frames.clear();
  reference = {};
  reference_points = reference_all_points = 0;
}

void LocalMap::update(const Map& map, const std::vector<MapPointId>& matched, KeyFrameId fallback, int max_key_frames) {
  ++epoch_;
  select_key_frames(map, matched, fallback, max_key_frames);
  copy_points(map);
  if (!key_frames.empty()) {
    reference.copy(map, key_frames.front());
    // A point seen by two key frames with depth is as sure as one seen by three without.
    const bool young = map.submap(reference.submap)->key_frames <= 2 || map.camera().bf > 0;
    reference_points = map.tracked_points(reference.id, young ? 2 : 3);
    reference_all_points = young ? reference_points : map.tracked_points(reference.id, 2);
  }
}

void LocalMap::select_key_frames(const Map& map, const std::vector<MapPointId>& matched, KeyFrameId fallback,
                                 int max_key_frames) {
  voted_.clear();
  for (const MapPointId& point_id : matched) {
    const MapPoint* point = map.find(point_id);
    if (!point) continue;
    for (const Observation& observation : point->observations) {
      int& votes = at_slot(votes_, observation.key_frame.slot);
      if (votes++ == 0) voted_.push_back(observation.key_frame);
    }
  }
  // Sorted by votes; of equal ones the older handle comes first.
  std::sort(voted_.begin(), voted_.end(), [&](KeyFrameId a, KeyFrameId b) {
    const int va = votes_[a.slot], vb = votes_[b.slot];
    return va != vb ? va > vb : a < b;
  });
  for (const KeyFrameId& key_frame : voted_) votes_[key_frame.slot] = 0;
  if (voted_.empty() && map.find(fallback)) voted_.push_back(fallback);

  key_frames.clear();
  const auto add = [&](KeyFrameId key_frame) {
    if (!key_frame.valid() || static_cast<int>(key_frames.size()) >= max_key_frames) return;
    uint32_t& seen = at_slot(key_frame_seen_, key_frame.slot);
    if (seen == epoch_) return;
    seen = epoch_;
    key_frames.push_back(key_frame);
  };
  for (const KeyFrameId& key_frame : voted_) add(key_frame);
  const size_t k1 = key_frames.size();
  for (size_t i = 0; i < k1 && static_cast<int>(key_frames.size()) < max_key_frames; ++i) {
    const KeyFrameId key_frame = key_frames[i];
    map.best_neighbours(key_frame, kBestNeighbours, neighbours_);
    for (const Neighbour& neighbour : neighbours_) add(neighbour.key_frame);
    for (const KeyFrameId& child : map.at(key_frame).children) add(child);
    add(map.at(key_frame).parent);
  }
}

void LocalMap::copy_points(const Map& map) {
  points.clear();
  for (const KeyFrameId& key_frame : key_frames) {
    for (const MapPointId& point : map.at(key_frame).points) {
      if (!point.valid()) continue;
      uint32_t& seen = at_slot(point_seen_, point.slot);
      if (seen == epoch_) continue;
      seen = epoch_;
      points.id.push_back(point);
    }
  }
  points.copy(map);
  reserve_ahead(match_ratio, points.size());
  match_ratio.resize(points.size());
  for (size_t k = 0; k < points.size(); ++k) {
    const MapPoint& point = map.at(points.id[k]);
    match_ratio[k] = expected_match_ratio(point);
    if (point.observations.size() < 2) at_slot(new_, points.id[k].slot) = epoch_;
  }
}

}  // namespace covis
