// SPDX-License-Identifier: Apache-2.0
// What the tracker asks of the mapper, and what it gets back. Plain values: the actors share nothing else but the map.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "covis/map/map.h"

namespace covis {

// How often a point was predicted in view and matched, since the tracker last told.
struct PointCount {
  MapPointId point;
  uint32_t visible = 0, found = 0;
};

// Make a key frame of this frame.
struct KeyFrameRequest {
  int64_t frame = 0;
  Timestamp stamp = 0;
  FeaturesPtr features;
  KeyFrameId reference;        // the pose is given relative to this key frame, which mapping may have moved; …
  double reference_scale = 1;  // KeyFrame::scale of it when the pose was told
  SE3 T_cr;  // … from its camera to the frame's. Without a reference it begins a submap: T_cw.
  std::vector<MapPointId> points;    // for each feature the point it was matched to, or an invalid handle
  std::vector<uint32_t> new_points;  // features whose depth makes a new point
  std::vector<PointCount> counts;
};

// Make the first two key frames and points of a monocular map, beside what is there. World = camera of the first.
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

// What loop closing did for a key frame.
struct LoopReport {
  KeyFrameId loop;            // the key frame it was tied to; invalid: no loop
  bool merged = false;        // the loop was none: it joined two submaps
  int merged_key_frames = 0;  // key frames of the submap that was moved
  int candidates = 0, matches = 0, inliers = 0, found_again = 0, fused = 0;  // the best candidate's
  double path = 0;          // travelled since that place, in the map's unit
  double correction = 0;    // of the key frame's place, in the map's unit
  double rotation_deg = 0;  // of its orientation
  double scale = 1;         // by which lengths near the key frame were too great
  double query_ms = 0, verify_ms = 0, correct_ms = 0, pose_graph_ms = 0;
  double full_ba_ms = 0;  // of the bundle adjustment that was committed with this key frame
};

struct MappingReport {
  int64_t frame = 0;     // of the request
  KeyFrameId key_frame;  // the new one; invalid when it was refused (the initial map did not hold)
  KeyFrameId first;      // initial maps: the first of the two
  int points_created = 0, points_fused = 0, points_culled = 0, key_frames_culled = 0;
  int ba_key_frames = 0, ba_points = 0, ba_observations = 0;
  bool ba_interrupted = false;
  double insert_ms = 0, cull_points_ms = 0, create_ms = 0, fuse_ms = 0, ba_ms = 0, cull_key_frames_ms = 0;
  double loop_ms = 0;
  double total_ms = 0;
  LoopReport loop;
};

}  // namespace covis
