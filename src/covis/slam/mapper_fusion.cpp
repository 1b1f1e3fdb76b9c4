// SPDX-License-Identifier: Apache-2.0
// Merging duplicate points between a new key frame and its neighbourhood (ORB-SLAM, VI-C; ORB-SLAM2, III-C).
#include <algorithm>

#include "covis/slam/mapper.h"

namespace covis {

int Mapper::fuse_neighbours(KeyFrameId current) {
  std::vector<KeyFrameId> targets;
  std::vector<MapPointId> own;
  {
    const auto map = map_.read();
    const int count = monocular() ? options_.mapper.create_neighbours_mono : options_.mapper.create_neighbours;
    const auto add = [&](KeyFrameId id) {
      if (id != current && std::find(targets.begin(), targets.end(), id) == targets.end()) targets.push_back(id);
    };
    for (const Neighbour& first : map->best_neighbours(current, count)) {
      add(first.key_frame);
      for (const Neighbour& second : map->best_neighbours(first.key_frame, options_.mapper.fuse_second_neighbours)) {
        add(second.key_frame);
      }
    }
    for (const MapPointId& id : map->at(current).points) {
      if (id.valid()) own.push_back(id);
    }
  }
  const FuseOptions fuse_options{.window = options_.mapper.fuse_window};
  int fused = 0;
  for (const KeyFrameId& target : targets) fused += fuser_.fuse(map_, target, own, fuse_options);

  // And the neighbourhood's points into the new key frame.
  std::vector<MapPointId> others;
  {
    const auto map = map_.read();
    for (const KeyFrameId& target : targets) {
      const KeyFrame* key_frame = map->find(target);
      if (!key_frame) continue;
      for (const MapPointId& id : key_frame->points) {
        if (id.valid()) others.push_back(id);
      }
    }
  }
  std::sort(others.begin(), others.end());
  others.erase(std::unique(others.begin(), others.end()), others.end());
  fused += fuser_.fuse(map_, current, others, fuse_options);

  const auto map = map_.write();
  const std::vector<MapPointId> points = map->at(current).points;
  for (const MapPointId& id : points) {
    if (id.valid()) map->refresh_point(id);
  }
  return fused;
}

}  // namespace covis
