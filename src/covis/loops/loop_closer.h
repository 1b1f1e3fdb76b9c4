// SPDX-License-Identifier: Apache-2.0
// Loop closing: recognises that a new key frame sees a place mapped before, and bends the map so that both are one.
// Synchronous; works on copies and commits under short write guards. Called by the mapping thread after local mapping
// of a key frame, so that the map has one writer.
// Source: Mur-Artal, Montiel, Tardós, "ORB-SLAM", T-RO 2015, section VII.
#pragma once

#include <optional>
#include <vector>

#include "covis/loops/loop_consensus.h"
#include "covis/loops/loop_detector.h"
#include "covis/loops/loop_verifier.h"
#include "covis/map/shared_map.h"
#include "covis/matching/point_fuser.h"

namespace covis {

class LoopCloser {
 public:
  LoopCloser(SharedMap& map, Sensor sensor, const LoopOptions& options, int seed)
      : map_(map), sensor_(sensor), options_(options), verifier_(sensor, options, seed) {}

  // Closes the loop, or joins the submaps, that `current`, just mapped, shows; if any.
  LoopReport process(KeyFrameId current);
  // The map is begun anew.
  void reset() {
    detector_.reset();
    consensus_.reset();
  }

 private:
  std::optional<Loop> recognise(KeyFrameId current, const std::vector<KeyFrameId>& places, LoopReport& report);
  bool confirmed(KeyFrameId current, const Loop& claim, RefusedPlace& refused);
  // False when the map refused to join.
  bool correct(KeyFrameId current, const Loop& loop, LoopReport& report);

  SharedMap& map_;
  const Sensor sensor_;
  const LoopOptions options_;
  LoopDetector detector_;
  LoopVerifier verifier_;
  LoopConsensus consensus_;
  PointFuser fuser_;
};

}  // namespace covis
