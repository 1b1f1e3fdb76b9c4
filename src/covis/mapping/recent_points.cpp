// SPDX-License-Identifier: Apache-2.0
#include "covis/mapping/recent_points.h"

namespace covis {
namespace {

constexpr uint32_t kAsked = 2;   // key frames after which a point must have been observed again
constexpr uint32_t kPassed = 3;  // key frames after which it is a point like others

// The number of its observations; one with depth counts as two.
int views(const Map& map, const MapPoint& point) {
  int count = 0;
  for (const Observation& o : point.observations)
    count += map.at(o.key_frame).features->has_depth(static_cast<int>(o.feature)) ? 2 : 1;
  return count;
}

}  // namespace

int RecentPoints::cull(SharedMap& shared, KeyFrameId current, Sensor sensor, double min_found_ratio) {
  const int too_few = sensor == Sensor::monocular ? 2 : 3;  // views
  std::vector<MapPointId> failed;
  {
    const auto map = shared.read();
    const uint32_t serial = map->at(current).serial, submap = map->at(current).submap;
    std::erase_if(recent_, [&](Recent& recent) {
      const MapPoint* point = map->find(recent.point);
      if (!point) return true;  // erased, or replaced by a point that is not new, or that has its own entry here
      // The camera went elsewhere before the point could be observed again.
      if (map->at(point->observations.front().key_frame).submap != submap) return true;
      const bool rarely_found = static_cast<double>(point->found) < min_found_ratio * point->visible;
      const uint32_t age = serial - recent.serial;
      if (!rarely_found && (age < kAsked || views(*map, *point) > too_few)) return age >= kPassed;
      failed.push_back(recent.point);
      return true;
    });
  }
  if (failed.empty()) return 0;
  const auto map = shared.write();
  int culled = 0;
  for (const MapPointId& id : failed) culled += map->erase_point(id);
  return culled;
}

}  // namespace covis
