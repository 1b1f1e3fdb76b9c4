// SPDX-License-Identifier: Apache-2.0
// Tells the features of a frame that show things which move by themselves: people, cars, a book in a hand. Matches that
// the pose refused lie all over a frame; those on one moving thing lie side by side, at one distance, and are displaced
// alike. A match that slid along a straight edge is too, so displacements along a line of features do not count.
// Depth tells what belongs to one thing, so that nothing is found without it.
// Measured: docs/notes/061-things-that-move.md.
#pragma once

#include <cstdint>
#include <vector>

#include "covis/tracking/local_map.h"
#include "covis/tracking/tracked_frame.h"

namespace covis {

// Keeps its work space between frames: it allocates nothing in a steady state.
class MovingFeatures {
 public:
  MovingFeatures();
  // Sets TrackedFrame::moved of the features on what moves, after the frame's pose was found. Without thirty points
  // that two key frames observe, and that stand, nothing is found.
  void find(TrackedFrame& frame, const LocalMap& local_map, const Pinhole& camera);

 private:
  // A match that the pose refused by its pixel, and how far from there its feature is.
  struct Displaced {
    uint32_t feature;
    Eigen::Vector2d by;  // pixels
  };
  void find_displaced(const TrackedFrame& frame, const Pinhole& camera);
  bool moves_with_others(const TrackedFrame& frame, const Displaced& displaced, float radius) const;
  void spread(TrackedFrame& frame, float radius);

  std::vector<Displaced> displaced_;
  std::vector<int32_t> displaced_of_;  // by feature: its index in displaced_, or -1
  std::vector<uint32_t> moving_;       // features that move, by this frame or by an earlier one
  std::vector<uint8_t> looked_at_;     // by feature: its surroundings were
  std::vector<Timestamp> spread_;      // by feature: TrackedFrame::moved as its surroundings have it
};

}  // namespace covis
