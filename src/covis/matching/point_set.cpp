// SPDX-License-Identifier: Apache-2.0
#include "covis/matching/point_set.h"

#include <algorithm>
#include <bit>

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

// Marks each point's slot with a bit, so that reading the bits gives the points sorted and once. Points that key frames
// hold are live (map_check.cpp), so that the slot tells the handle.
std::vector<MapPointId> points_of(const Map& map, std::span<const KeyFrameId> key_frames) {
  std::vector<const KeyFrame*> sources;
  uint32_t lowest = MapPointId::kNoSlot, highest = 0;
  for (const KeyFrameId& key_frame : key_frames) {
    const KeyFrame* source = map.find(key_frame);
    if (!source) continue;
    sources.push_back(source);
    for (const MapPointId& point : source->points) {
      lowest = std::min(lowest, point.slot);
      if (point.valid()) highest = std::max(highest, point.slot);
    }
  }
  if (lowest > highest) return {};
  std::vector<uint64_t> seen((highest - lowest) / 64 + size_t{1});
  for (const KeyFrame* source : sources) {
    for (const MapPointId& point : source->points) {
      if (point.valid()) seen[(point.slot - lowest) / 64] |= uint64_t{1} << (point.slot - lowest) % 64;
    }
  }
  size_t count = 0;
  for (const uint64_t bits : seen) count += static_cast<size_t>(std::popcount(bits));
  std::vector<MapPointId> points;
  points.reserve(count);
  for (size_t k = 0; k < seen.size(); ++k) {
    for (uint64_t bits = seen[k]; bits != 0; bits &= bits - 1)
      points.push_back(
          map.point_in(lowest + static_cast<uint32_t>(64 * k + static_cast<size_t>(std::countr_zero(bits)))));
  }
  return points;
}

int32_t index_of(const PointSet& points, MapPointId point) {
  const auto at = std::lower_bound(points.id.begin(), points.id.end(), point);
  return at == points.id.end() || *at != point ? -1 : static_cast<int32_t>(at - points.id.begin());
}

}  // namespace covis
