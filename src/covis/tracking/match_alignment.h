// SPDX-License-Identifier: Apache-2.0
// The pose of a tracked frame from matches whose places are refined (matching/patch_alignment.h).
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "covis/map/shared_map.h"
#include "covis/matching/patch_alignment.h"
#include "covis/optimization/pose_optimization.h"
#include "covis/tracking/tracked_frame.h"

namespace covis {

// Keeps its work space between frames.
class MatchAlignment {
 public:
  // Refines frame.T_cw, which its matches were fitted with, and its information, and drops matches that do not fit as
  // closely as aligned ones should. Returns how many map points are left; nothing, and everything stays as it was,
  // where these are fewer than `least` or than half of the matches fit, or where the map has moved since `moves`.
  std::optional<int> refine_pose(const SharedMap& map, const Pinhole& camera, int least, std::optional<uint64_t> moves,
                                 TrackedFrame& frame);

 private:
  struct Question {
    uint32_t feature = 0;
    PatchQuestion of_point;
  };
  void ask(const Map& map, const TrackedFrame& frame);
  void observe(const Pinhole& camera, const TrackedFrame& frame);

  std::vector<Question> questions_;  // by rising feature
  PoseObservations observations_;
  std::vector<uint8_t> inlier_;
};

}  // namespace covis
