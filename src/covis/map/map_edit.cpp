// SPDX-License-Identifier: Apache-2.0
#include "covis/map/map_edit.h"

#include <algorithm>

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

void MapEdit::touch_points_of(KeyFrameId key_frame) {
  for (const MapPointId& id : map_.at(key_frame).points) {
    if (id.valid()) touched_.push_back(id);
  }
}

}  // namespace covis
