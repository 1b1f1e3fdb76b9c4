// SPDX-License-Identifier: Apache-2.0
#include "covis/mapping/key_frame_culling.h"

namespace covis {
namespace {

struct Redundancy {
  int points = 0, redundant = 0;
};

// Three others see the point as finely as at `scale`, or a level more coarsely.
bool seen_by_others(const Map& map, KeyFrameId id, const MapPoint& point, float scale) {
  constexpr int kObservers = 3;  // others that must see a point for it to be redundant
  if (static_cast<int>(point.observations.size()) <= kObservers) return false;
  int others = 0;
  for (const Observation& observation : point.observations) {
    if (observation.key_frame == id) continue;
    const Features& other = *map.at(observation.key_frame).features;
    const float most = 1.01f * scale * other.pyramid->factor;  // 1.01: rounding
    if (other.pyramid->scale[other.level[observation.feature]] <= most && ++others >= kObservers) return true;
  }
  return false;
}

Redundancy count_redundant(const Map& map, KeyFrameId id, Sensor sensor, const CloseDepth& close_depth) {
  const double close = close_depth.metres(map.camera());
  const KeyFrame& key_frame = map.at(id);
  const Features& features = *key_frame.features;
  Redundancy counts;
  for (size_t i = 0; i < key_frame.points.size(); ++i) {
    if (!key_frame.points[i].valid()) continue;
    if (sensor != Sensor::monocular && !(features.depth[i] > 0 && features.depth[i] <= close)) continue;
    ++counts.points;
    counts.redundant +=
        seen_by_others(map, id, map.at(key_frame.points[i]), features.pyramid->scale[features.level[i]]);
  }
  return counts;
}

}  // namespace

int cull_key_frames(SharedMap& shared, KeyFrameId current, Sensor sensor, double max_redundancy,
                    const CloseDepth& close_depth) {
  const std::vector<Neighbour> neighbours = shared.read()->neighbours(current);
  int culled = 0;
  for (const Neighbour& neighbour : neighbours) {
    const KeyFrameId id = neighbour.key_frame;
    {
      const auto map = shared.read();
      // A loop edge is all that the next pose graph knows of a loop's measurement.
      if (map->is_root(id) || !map->at(id).loop_edges.empty()) continue;
      const Redundancy counts = count_redundant(*map, id, sensor, close_depth);
      if (counts.points == 0 || !(counts.redundant > max_redundancy * counts.points)) continue;
    }
    // No MapEdit: points keep normal and descriptor (architecture.md, decision 3).
    culled += shared.write()->erase_key_frame(id);
  }
  return culled;
}

}  // namespace covis
