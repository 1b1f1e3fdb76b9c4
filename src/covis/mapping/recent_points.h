// SPDX-License-Identifier: Apache-2.0
// Points on probation: a new point must be found again soon, or it goes.
// Source: Mur-Artal, Montiel, Tardós, "ORB-SLAM", T-RO 2015, section VI-B.
#pragma once

#include <cstdint>
#include <vector>

#include "covis/core/sensor.h"
#include "covis/map/shared_map.h"

namespace covis {

class RecentPoints {
 public:
  // A point made with the key frame of this serial.
  void add(MapPointId point, uint32_t serial) { recent_.push_back({point, serial}); }
  // Erases the points that tracking finds in less than a share of the views it predicts them in, and those that too few
  // key frames observe two key frames after they were made. After three a point stays, and so does one of another
  // submap than the current key frame's: that says nothing of it. Returns the number erased.
  int cull(SharedMap& map, KeyFrameId current, Sensor sensor, double min_found_ratio);
  size_t size() const { return recent_.size(); }

 private:
  struct Recent {
    MapPointId point;
    uint32_t serial = 0;  // the serial of the key frame it was made with
  };
  std::vector<Recent> recent_;
};

}  // namespace covis
