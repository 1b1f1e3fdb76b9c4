// SPDX-License-Identifier: Apache-2.0
// Changes of the map's points that leave everything derived from their observations right: when the edit ends, every
// point it touched and that lives gets its normal, its range of distances and its descriptor anew. A point that was
// only moved, or lost an observation, keeps its descriptor.
//
// An edit holds the write guard from its first change to the last refresh, so that no reader meets a point in between.
// It is short because callers work out values before they begin it, and bounded by the observations of what it touches.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "covis/map/shared_map.h"

namespace covis {

class MapEdit {
 public:
  // Holds the write guard until it ends.
  explicit MapEdit(SharedMap& shared) : guard_(shared.write()), map_(**guard_) {}
  // For a map that the caller may write to anyway.
  explicit MapEdit(Map& map) : map_(map) {}
  ~MapEdit();
  MapEdit(const MapEdit&) = delete;
  MapEdit& operator=(const MapEdit&) = delete;

  const Map* operator->() const { return &map_; }
  const Map& operator*() const { return map_; }
  // The map itself, for changes of anything but its points.
  Map& map() { return map_; }

  // As those of Map.
  MapPointId add_point(const Eigen::Vector3d& position_w, KeyFrameId reference, uint32_t feature);
  bool add_observation(MapPointId point, KeyFrameId key_frame, uint32_t feature);
  bool erase_observation(MapPointId point, KeyFrameId key_frame);
  bool replace_point(MapPointId old, MapPointId by);
  bool set_position(MapPointId id, const Eigen::Vector3d& position_w);

 private:
  std::optional<SharedMap::WriteGuard> guard_;
  Map& map_;
  std::vector<MapPointId> touched_;  // everything derived is made anew
  std::vector<MapPointId> moved_;    // normal and range alone
};

// Refreshes all points that these key frames observe, after PointFuser, which leaves that to its caller: works it out
// under a read guard, and stores it under a write guard. For the one thread that writes to the map.
void refresh_points_of(SharedMap& shared, std::span<const KeyFrameId> key_frames);

}  // namespace covis
