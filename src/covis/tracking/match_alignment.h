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
  MatchAlignment();

  // Refines frame.T_cw, which its matches were fitted with, and its information. The matches stay, also those that do
  // not fit as closely as aligned ones should. The pose stays too where these are more than half, or where the map has
  // moved since `moves`.
  void refine_pose(const SharedMap& map, const Pinhole& camera, std::optional<uint64_t> moves, TrackedFrame& frame);

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
