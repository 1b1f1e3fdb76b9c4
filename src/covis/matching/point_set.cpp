// SPDX-License-Identifier: Apache-2.0
#include "covis/matching/point_set.h"

#include <algorithm>

namespace covis {
namespace {

// Gives all arrays of map points this length.
void resize(PointSet& points, size_t n) {
  for (auto* array : {&points.px, &points.py, &points.pz}) array->resize(n);
  for (auto* array : {&points.nx, &points.ny, &points.nz, &points.d_min, &points.d_max}) array->resize(n);
  points.descriptor.resize(n);
}

void write(const MapPoint& point, PointSet& points, size_t k) {
  points.px[k] = point.position_w.x();
  points.py[k] = point.position_w.y();
  points.pz[k] = point.position_w.z();
  points.nx[k] = static_cast<float>(point.normal_w.x());
  points.ny[k] = static_cast<float>(point.normal_w.y());
  points.nz[k] = static_cast<float>(point.normal_w.z());
  points.d_min[k] = point.d_min;
  points.d_max[k] = point.d_max;
  points.descriptor[k] = point.descriptor;
}

}  // namespace

void PointSet::clear() {
  id.clear();
  for (auto* array : {&px, &py, &pz}) array->clear();
  for (auto* array : {&nx, &ny, &nz, &d_min, &d_max}) array->clear();
  descriptor.clear();
  level.clear();
}

void PointSet::reserve(size_t n) {
  id.reserve(n);
  for (auto* array : {&px, &py, &pz}) array->reserve(n);
  for (auto* array : {&nx, &ny, &nz, &d_min, &d_max}) array->reserve(n);
  descriptor.reserve(n);
  level.reserve(n);
}

void PointSet::copy(const Map& map) {
  resize(*this, size());
  for (size_t k = 0; k < size(); ++k) write(map.at(id[k]), *this, k);
}

void PointSet::add(MapPointId point, const MapPoint& source) {
  id.push_back(point);
  px.push_back(source.position_w.x());
  py.push_back(source.position_w.y());
  pz.push_back(source.position_w.z());
  nx.push_back(static_cast<float>(source.normal_w.x()));
  ny.push_back(static_cast<float>(source.normal_w.y()));
  nz.push_back(static_cast<float>(source.normal_w.z()));
  d_min.push_back(source.d_min);
  d_max.push_back(source.d_max);
  descriptor.push_back(source.descriptor);
}

void PointSet::add_seen(MapPointId point, const Eigen::Vector3d& position_w, const Descriptor& seen_as,
                        int seen_at_level) {
  id.push_back(point);
  px.push_back(position_w.x());
  py.push_back(position_w.y());
  pz.push_back(position_w.z());
  descriptor.push_back(seen_as);
  level.push_back(static_cast<uint8_t>(seen_at_level));
}

std::vector<MapPointId> points_of(const Map& map, std::span<const KeyFrameId> key_frames) {
  std::vector<MapPointId> points;
  std::vector<bool> taken;  // by slot, so that what many see is sorted once
  for (const KeyFrameId& key_frame : key_frames) {
    const KeyFrame* source = map.find(key_frame);
    if (!source) continue;
    for (const MapPointId& point : source->points) {
      if (!point.valid()) continue;
      if (key_frames.size() > 1) {
        if (point.slot >= taken.size()) taken.resize(std::max(point.slot + size_t{1}, 2 * taken.size()));
        if (taken[point.slot]) continue;
        taken[point.slot] = true;
      }
      points.push_back(point);
    }
  }
  std::sort(points.begin(), points.end());
  points.erase(std::unique(points.begin(), points.end()), points.end());
  return points;
}

int32_t index_of(const PointSet& points, MapPointId point) {
  const auto at = std::lower_bound(points.id.begin(), points.id.end(), point);
  return at == points.id.end() || *at != point ? -1 : static_cast<int32_t>(at - points.id.begin());
}

}  // namespace covis
