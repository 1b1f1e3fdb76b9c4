// SPDX-License-Identifier: Apache-2.0
// The frame before the current one, and the map as that saw it.
#pragma once

#include <cstdint>
#include <vector>

#include "covis/map/relative_pose.h"
#include "covis/tracking/tracked_frame.h"

namespace covis {

struct LastFrame {
  TrackedFrame frame;
  RelativePose pose;         // pose of the last frame that had one
  uint32_t submap = 0;       // submap of its reference key frame
  KeyFrameId new_reference;  // a key frame just made, to become the reference
  bool map_changed = false;  // the map changed since the frame was brought up to date with it
  uint64_t moves = 0;        // Map::moves() when it was

  // It is this key frame.
  void become(const Map& map, KeyFrameId key_frame);
  // The frame's own depth gives points for the next frame alone: the map may have few yet.
  void add_depth_points(const std::vector<uint32_t>& features, const Pinhole& camera);
  // It became this key frame: it gets the points that mapping gave the key frame.
  void take_points(const Map& map, KeyFrameId key_frame);
  // Its points are where the map has them now.
  void refresh_points(const Map& map);
};

}  // namespace covis
