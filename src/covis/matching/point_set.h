// SPDX-License-Identifier: Apache-2.0
// Points copied out of the map, as arrays: what a search by projection needs of them, without the map's lock. Serves
// the local map of tracking, the place a loop leads to, fusion, and the points that the last frame showed.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "covis/core/aligned.h"
#include "covis/map/map.h"

namespace covis {

// The part of a point that decides from where it can be seen; units and frames as in PointSet.
struct ViewablePoint {
  Eigen::Vector3d position_w;
  Eigen::Vector3f normal_w;
  float d_min = 0, d_max = 0;

  explicit ViewablePoint(const MapPoint& point)
      : position_w(point.position_w), normal_w(point.normal_w.cast<float>()), d_min(point.d_min), d_max(point.d_max) {}
  ViewablePoint(const Eigen::Vector3d& position, const Eigen::Vector3f& normal, float nearest, float farthest)
      : position_w(position), normal_w(normal), d_min(nearest), d_max(farthest) {}
};

struct PointSet {
  std::vector<MapPointId> id;            // an invalid handle: a point that is not in the map
  AlignedVector<double> px, py, pz;      // world position, metres
  AlignedVector<float> nx, ny, nz;       // mean viewing direction, from the observers to the point
  AlignedVector<float> d_min, d_max;     // distances at which it can be seen, metres
  AlignedVector<Descriptor> descriptor;  // representative descriptor
  AlignedVector<uint8_t> level;          // pyramid level at which it was just seen; only in sets made by add_seen()

  size_t size() const { return id.size(); }
  bool empty() const { return id.empty(); }
  Eigen::Vector3d position(size_t k) const { return {px[k], py[k], pz[k]}; }
  ViewablePoint viewable(size_t k) const { return {position(k), {nx[k], ny[k], nz[k]}, d_min[k], d_max[k]}; }
  void clear();
  void reserve(size_t n);
  // Fills the other arrays with the points of the map that `id` names; all must live.
  void copy(const Map& map);
  // One point of the map, which must live.
  void add(MapPointId point, const MapPoint& source);
  // One keypoint of a known place.
  void add_seen(MapPointId point, const Eigen::Vector3d& position_w, const Descriptor& seen_as, int seen_at_level);
};

// The points that key frames observe, each once. In the order of their handles, so that index_of() finds them.
std::vector<MapPointId> points_of(const Map& map, std::span<const KeyFrameId> key_frames);
// The place of a point in a set in the order of handles; -1 when it is not there.
int32_t index_of(const PointSet& points, MapPointId point);

}  // namespace covis
