// SPDX-License-Identifier: Apache-2.0
// What mapping and loop closing report of a key frame.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "covis/map/map_requests.h"

namespace covis {

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

struct MappingReport : KeyFrameMade {
  int points_created = 0, points_fused = 0, points_culled = 0, key_frames_culled = 0;
  int ba_key_frames = 0, ba_points = 0, ba_observations = 0;
  bool ba_interrupted = false;
  double insert_ms = 0, cull_points_ms = 0, create_ms = 0, fuse_ms = 0, ba_ms = 0, cull_key_frames_ms = 0;
  double loop_ms = 0;
  double total_ms = 0;
  LoopReport loop;
};

}  // namespace covis
