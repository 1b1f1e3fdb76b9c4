// SPDX-License-Identifier: Apache-2.0
// A whole submap as a bundle adjustment problem, and its way back into a map that has grown meanwhile.
// Source: Mur-Artal and Tardós, "ORB-SLAM2", T-RO 2017, section III-D.
#pragma once

#include <memory>
#include <optional>

#include "covis/loops/background_adjustment.h"
#include "covis/mapping/map_problem.h"

namespace covis {

// A copy of the submap that a key frame belongs to; nothing when it has fewer than two key frames.
std::optional<MapProblem> copy_submap(const Map& map, KeyFrameId key_frame);

// Writes an adjusted submap to the map, and its camera where that was adjusted too. What came meanwhile moves along:
// key frames keep their poses relative to their parents in the spanning tree, points relative to their reference key
// frames. Works out all places under a read guard before it takes the write guard. Nothing (and nothing done) when the
// submap was given up meanwhile.
std::optional<KeyFrameMoves> apply_submap(const MapProblem& adjusted, SharedMap& shared,
                                          const std::optional<Pinhole>& camera = {});

// Full bundle adjustment, after a loop.
class FullAdjustment : public AdjustmentJob {
 public:
  // Null when there is nothing to adjust.
  static std::unique_ptr<FullAdjustment> of(const Map& map, KeyFrameId key_frame, int iterations);

  AdjustmentKind kind() const override { return AdjustmentKind::full; }
  bool run(const std::atomic<bool>& interrupt) override;
  std::optional<KeyFrameMoves> apply(SharedMap& map) const override;

 private:
  FullAdjustment(MapProblem submap, int iterations) : submap_(std::move(submap)), iterations_(iterations) {}

  MapProblem submap_;
  const int iterations_;
};

}  // namespace covis
