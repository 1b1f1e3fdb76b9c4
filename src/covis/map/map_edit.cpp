// SPDX-License-Identifier: Apache-2.0
#include "covis/map/map_edit.h"

#include <algorithm>
#include <iterator>
#include <utility>

namespace covis {
namespace {

void make_unique(std::vector<MapPointId>& points) {
  std::sort(points.begin(), points.end());
  points.erase(std::unique(points.begin(), points.end()), points.end());
}

}  // namespace

MapEdit::~MapEdit() {
  make_unique(touched_);
  make_unique(moved_);
  for (const MapPointId& id : touched_) {
    if (map_.find(id)) map_.refresh_point(id);
  }
  for (const MapPointId& id : moved_) {
    if (map_.find(id) && !std::binary_search(touched_.begin(), touched_.end(), id)) map_.refresh_point_geometry(id);
  }
}

MapPointId MapEdit::add_point(const Eigen::Vector3d& position_w, KeyFrameId reference, uint32_t feature) {
  const MapPointId id = map_.add_point(position_w, reference, feature);
  if (id.valid()) touched_.push_back(id);
  return id;
}

bool MapEdit::add_observation(MapPointId point, KeyFrameId key_frame, uint32_t feature) {
  if (!map_.add_observation(point, key_frame, feature)) return false;
  touched_.push_back(point);
  return true;
}

bool MapEdit::erase_observation(MapPointId point, KeyFrameId key_frame) {
  if (!map_.erase_observation(point, key_frame)) return false;
  moved_.push_back(point);
  return true;
}

bool MapEdit::replace_point(MapPointId old, MapPointId by) {
  if (!map_.replace_point(old, by)) return false;
  touched_.push_back(by);
  return true;
}

bool MapEdit::set_position(MapPointId id, const Eigen::Vector3d& position_w) {
  moved_.push_back(id);  // its observers may have moved even when the position is refused
  return map_.set_position(id, position_w);
}

void refresh_points_of(SharedMap& shared, std::span<const KeyFrameId> key_frames) {
  std::vector<std::pair<MapPointId, PointAppearance>> seen;
  {
    const auto map = shared.read();
    std::vector<MapPointId> points;
    for (const KeyFrameId& key_frame : key_frames) {
      const std::vector<MapPointId>& observed = map->at(key_frame).points;
      std::copy_if(observed.begin(), observed.end(), std::back_inserter(points),
                   [](MapPointId id) { return id.valid(); });
    }
    make_unique(points);
    seen.reserve(points.size());
    for (const MapPointId& id : points) seen.emplace_back(id, map->appearance(id));
  }
  const auto map = shared.write();
  for (const auto& [id, appearance] : seen) map->set_appearance(id, appearance);
}

}  // namespace covis
