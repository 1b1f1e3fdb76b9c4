// SPDX-License-Identifier: Apache-2.0
// The requests of tracking to mapping, and the answers. Plain values: the actors share nothing else but the map.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "covis/map/relative_pose.h"

namespace covis {

// How often a point was predicted in view and matched, since tracking last reported.
struct PointCount {
  MapPointId point;
  uint32_t visible = 0, found = 0;
};

// A frame without a pose, to be located now that the map around it is there.
struct UnlocatedFrame {
  int64_t frame = 0;
  Timestamp stamp = 0;
  FeaturesPtr features;
  KeyFrameId near;  // the reference key frame with which the camera was found after it; invalid: it was not found yet
};

// A frame that was located afterwards.
struct LocatedFrame {
  int64_t frame = 0;
  RelativePose pose;
};

// The rows of images prove to be exposed in other steps than the map's camera has: Pinhole::row_time of the camera that
// this was found with, and what it is to be.
struct ShutterChange {
  double from = 0, to = 0;
};

// Make a key frame of this frame.
struct KeyFrameRequest {
  int64_t frame = 0;
  Timestamp stamp = 0;
  FeaturesPtr features;
  std::shared_ptr<const KeptDepth> depth;  // may be null
  RelativePose pose;  // relative to a key frame, which mapping may have moved; without one it begins a submap: T_cw
  std::vector<MapPointId> points;    // for each feature the point it was matched to, or an invalid handle
  std::vector<uint32_t> new_points;  // features whose depth makes a new point
  std::vector<PointCount> counts;
  std::vector<UnlocatedFrame> unlocated;                // earlier frames, newest first
  Eigen::Vector3d turn_rate = Eigen::Vector3d::Zero();  // of the rays, radians a second; zero: not known
  std::optional<ShutterChange> shutter;
  bool doubted_depth = false;    // true: neither noise nor camera is to be estimated
  bool suspected_depth = false;  // true: it was doubted once, so that every key frame is compared
};

// Make the first two key frames and points of a monocular submap, beside what is there. World = camera of the first.
struct InitialMapRequest {
  struct View {
    int64_t frame = 0;
    Timestamp stamp = 0;
    FeaturesPtr features;
  };
  struct Point {
    Eigen::Vector3d position_w;
    uint32_t feature_first = 0, feature_second = 0;
  };
  View first, second;
  SE3 T_21;  // first camera to second, translation in units to be scaled
  std::vector<Point> points;
};

// The answer to either request.
struct KeyFrameMade {
  int64_t frame = 0;       // the request's
  KeyFrameId key_frame{};  // the new one; invalid when the request was refused
  KeyFrameId first{};      // initial maps: the first of the two
};

}  // namespace covis
