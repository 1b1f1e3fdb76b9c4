// SPDX-License-Identifier: Apache-2.0
// Map points: observations, replacement, and what is derived from the observers.
#include <algorithm>
#include <array>
#include <iterator>
#include <utility>

#include "covis/core/log.h"
#include "covis/core/reserve.h"
#include "covis/map/map.h"

namespace covis {
namespace {

// More observations than this add nothing to the representative descriptor; the first ones are compared.
constexpr size_t kMaxCompared = 48;

uint32_t sum_of_frames(uint32_t a, uint32_t b) {
  return static_cast<uint32_t>(std::min(uint64_t{a} + b, uint64_t{MapPoint::kMostFrames}));
}

// Normal and range of distances.
void derive_geometry(const Map& map, const MapPoint& point, PointAppearance& seen) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Observation& o : point.observations) {
    const Eigen::Vector3d ray = point.position_w - map.at(o.key_frame).T_cw.centre();
    const double distance = ray.norm();
    if (distance > 0) sum += ray / distance;
    if (o.key_frame != point.reference) continue;
    const Features& f = *map.at(o.key_frame).features;
    seen.d_max = static_cast<float>(distance) * f.pyramid->scale[f.level[o.feature]];
    seen.d_min = seen.d_max / (f.pyramid->scale.back() / f.pyramid->base);
  }
  seen.normal_w = sum / static_cast<double>(point.observations.size());
}

}  // namespace

MapPointId Map::add_point(const Eigen::Vector3d& position_w, KeyFrameId reference, uint32_t feature) {
  KeyFrame* key_frame = key_frames_.find(reference);
  if (!key_frame || feature >= key_frame->points.size() || key_frame->points[feature].valid()) return {};
  if (!position_w.allFinite()) {
    ++refused_non_finite_;
    log(LogLevel::error, "a map point that is not finite was refused");
    return {};
  }
  MapPoint point;
  point.position_w = position_w;
  point.reference = reference;
  point.descriptor = key_frame->features->descriptor[feature];
  reserve_one_more(point.observations);
  point.observations.push_back({reference, feature});
  const MapPointId id = points_.insert(std::move(point));
  key_frame->points[feature] = id;
  refresh_point_geometry(id);
  return id;
}

bool Map::add_observation(MapPointId id, KeyFrameId key_frame_id, uint32_t feature) {
  MapPoint* point = points_.find(id);
  KeyFrame* key_frame = key_frames_.find(key_frame_id);
  if (!point || !key_frame || feature >= key_frame->points.size() || key_frame->points[feature].valid()) return false;
  if (at(point->reference).submap != key_frame->submap) return false;
  const auto place = std::ranges::lower_bound(point->observations, key_frame_id, {}, &Observation::key_frame);
  if (place != point->observations.end() && place->key_frame == key_frame_id) return false;
  for (const Observation& other : point->observations) add_weight(key_frame_id, other.key_frame, 1);
  const auto at = place - point->observations.begin();
  reserve_one_more(point->observations);
  point->observations.insert(point->observations.begin() + at, {key_frame_id, feature});
  key_frame->points[feature] = id;
  return true;
}

bool Map::erase_observation(MapPointId id, KeyFrameId key_frame_id) {
  MapPoint* point = points_.find(id);
  if (!point) return false;
  const auto at = std::ranges::lower_bound(point->observations, key_frame_id, {}, &Observation::key_frame);
  if (at == point->observations.end() || at->key_frame != key_frame_id) return false;
  key_frames_.at(key_frame_id).points[at->feature] = {};
  point->observations.erase(at);
  for (const Observation& other : point->observations) add_weight(key_frame_id, other.key_frame, -1);
  const std::vector<Observation>& left = point->observations;
  const bool held =
      left.size() >= 2 ||
      (left.size() == 1 && this->at(left[0].key_frame).features->has_depth(static_cast<int>(left[0].feature)));
  if (!held) {
    erase_point(id);
  } else if (point->reference == key_frame_id) {
    point->reference = left.front().key_frame;
    refresh_point_geometry(id);
  }
  return true;
}

void Map::unlink_observations(MapPointId id) {
  MapPoint& point = points_.at(id);
  for (size_t i = 0; i < point.observations.size(); ++i) {
    const Observation& o = point.observations[i];
    key_frames_.at(o.key_frame).points[o.feature] = {};
    for (size_t j = 0; j < i; ++j) add_weight(o.key_frame, point.observations[j].key_frame, -1);
  }
  point.observations.clear();
}

bool Map::erase_point(MapPointId id) {
  if (!points_.find(id)) return false;
  unlink_observations(id);
  return points_.erase(id);
}

bool Map::replace_point(MapPointId old, MapPointId by) {
  if (old == by || !points_.find(old) || !points_.find(by)) return false;
  if (at(at(old).reference).submap != at(at(by).reference).submap) return false;
  MapPoint& from = points_.at(old);
  MapPoint& to = points_.at(by);
  std::vector<Observation> moved, let_go;
  for (const Observation& o : from.observations) (to.seen_by(o.key_frame) ? let_go : moved).push_back(o);
  for (size_t k = 0; k < let_go.size(); ++k) {
    key_frames_.at(let_go[k].key_frame).points[let_go[k].feature] = {};
    for (const Observation& o : moved) add_weight(let_go[k].key_frame, o.key_frame, -1);
    for (size_t j = 0; j < k; ++j) add_weight(let_go[k].key_frame, let_go[j].key_frame, -1);
  }
  // Pairs of those that are moved go on sharing one point.
  for (const Observation& m : moved) {
    key_frames_.at(m.key_frame).points[m.feature] = by;
    for (const Observation& o : to.observations) add_weight(m.key_frame, o.key_frame, 1);
  }
  std::vector<Observation> all;
  all.reserve(to.observations.size() + moved.size());
  std::ranges::merge(to.observations, moved, std::back_inserter(all), {}, &Observation::key_frame,
                     &Observation::key_frame);
  to.observations = std::move(all);
  to.visible = sum_of_frames(to.visible, from.visible);
  to.found = sum_of_frames(to.found, from.found);
  points_.erase(old);
  replaced_by_[old] = {by, next_serial_ - 1};
  refresh_point(by);
  return true;
}

MapPointId Map::forwarded(MapPointId id) const {
  while (!points_.find(id)) {
    const auto next = replaced_by_.find(id);
    if (next == replaced_by_.end()) return {};
    id = next->second.by;
  }
  return id;
}

void Map::forget_forwarding(uint32_t before_serial) {
  std::erase_if(replaced_by_, [&](const auto& entry) { return entry.second.serial < before_serial; });
}

bool Map::set_position(MapPointId id, const Eigen::Vector3d& position_w) {
  MapPoint* point = points_.find(id);
  if (!point) return false;
  if (!position_w.allFinite()) {
    ++refused_non_finite_;
    log(LogLevel::error, "a point position that is not finite was refused");
    return false;
  }
  point->position_w = position_w;
  return true;
}

void Map::refresh_point_geometry(MapPointId id) {
  const MapPoint& point = at(id);
  PointAppearance seen{point.normal_w, point.d_min, point.d_max, point.descriptor};
  derive_geometry(*this, point, seen);
  set_appearance(id, seen);
}

PointAppearance Map::appearance(MapPointId id) const {
  const MapPoint& point = at(id);
  PointAppearance seen{point.normal_w, point.d_min, point.d_max, point.descriptor};
  derive_geometry(*this, point, seen);
  const size_t n = std::min(point.observations.size(), kMaxCompared);
  if (n <= 1) return seen;
  std::array<const Descriptor*, kMaxCompared> descriptors;
  for (size_t i = 0; i < n; ++i) {
    const Observation& o = point.observations[i];
    descriptors[i] = &at(o.key_frame).features->descriptor[o.feature];
  }
  int best = kHammingBeyond;
  std::array<uint16_t, kMaxCompared * kMaxCompared> between;  // row i: the distances of the ith from all
  for (size_t i = 0; i < n; ++i) {
    between[i * n + i] = 0;
    for (size_t j = 0; j < i; ++j) {
      const int distance = hamming(*descriptors[i], *descriptors[j]);
      between[i * n + j] = between[j * n + i] = static_cast<uint16_t>(distance);
    }
  }
  for (size_t i = 0; i < n; ++i) {
    uint16_t* const row = between.data() + i * n;
    uint16_t* const middle = row + (n - 1) / 2;
    std::nth_element(row, middle, row + n);
    if (*middle < best) {
      best = *middle;
      seen.descriptor = *descriptors[i];
    }
  }
  return seen;
}

void Map::set_appearance(MapPointId id, const PointAppearance& appearance) {
  MapPoint& point = points_.at(id);
  point.normal_w = appearance.normal_w;
  point.d_min = appearance.d_min;
  point.d_max = appearance.d_max;
  point.descriptor = appearance.descriptor;
}

void Map::count_visible(MapPointId id, uint32_t frames) {
  if (MapPoint* point = points_.find(id)) point->visible = sum_of_frames(point->visible, frames);
}

void Map::count_found(MapPointId id, uint32_t frames) {
  if (MapPoint* point = points_.find(id)) point->found = sum_of_frames(point->found, frames);
}

std::vector<MapPointId> Map::points() const {
  std::vector<MapPointId> ids;
  ids.reserve(points_.size());
  for_each_point([&](MapPointId id, const MapPoint&) { ids.push_back(id); });
  return ids;
}

}  // namespace covis
