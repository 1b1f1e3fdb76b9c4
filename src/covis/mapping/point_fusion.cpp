// SPDX-License-Identifier: Apache-2.0
#include "covis/mapping/point_fusion.h"

#include <algorithm>
#include <vector>

#include "covis/map/map_edit.h"

namespace covis {
namespace {

// The best covisible key frames, and the best of each of these.
std::vector<KeyFrameId> neighbourhood(const Map& map, KeyFrameId current, int neighbours, int second_neighbours) {
  std::vector<KeyFrameId> list;
  const auto add = [&](KeyFrameId id) {
    if (id != current && std::find(list.begin(), list.end(), id) == list.end()) list.push_back(id);
  };
  for (const Neighbour& first : map.best_neighbours(current, neighbours)) {
    add(first.key_frame);
    for (const Neighbour& second : map.best_neighbours(first.key_frame, second_neighbours)) add(second.key_frame);
  }
  return list;
}

}  // namespace

int fuse_neighbours_unrefreshed(SharedMap& shared, KeyFrameId current, Sensor sensor, const MapperOptions& options,
                                PointFuser& fuser, FuseMemory* memory) {
  std::vector<KeyFrameId> targets;
  std::vector<MapPointId> own;
  {
    const auto map = shared.read();
    targets = neighbourhood(*map, current, options.neighbours(sensor), options.fuse_second_neighbours);
    for (const MapPointId& id : map->at(current).points) {
      if (id.valid()) own.push_back(id);
    }
  }
  const FuseOptions fuse_options{.window = options.fuse_window};
  int fused = 0;
  for (const KeyFrameId& target : targets) fused += fuser.fuse(shared, target, own, fuse_options, memory);
  const std::vector<MapPointId> others = points_of(*shared.read(), targets);
  return fused + fuser.fuse(shared, current, others, fuse_options, memory);
}

int fuse_neighbours(SharedMap& shared, KeyFrameId current, Sensor sensor, const MapperOptions& options,
                    PointFuser& fuser) {
  const int fused = fuse_neighbours_unrefreshed(shared, current, sensor, options, fuser);
  refresh_points_of(shared, {&current, 1});
  return fused;
}

}  // namespace covis
