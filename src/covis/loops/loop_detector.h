// SPDX-License-Identifier: Apache-2.0
// Finds places that look like a new key frame's: by words, at least as alike as the key frame's least similar
// neighbour. Those far along the covisibility graph come first: what is near looks alike too, and would take the place
// of those that may close a loop.
// Source: Mur-Artal, Montiel, Tardós, "ORB-SLAM", T-RO 2015, section VII-A.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "covis/map/map.h"

namespace covis {

class LoopDetector {
 public:
  static constexpr uint32_t kBetweenLoops = 10;  // key frames: after a loop, and between a key frame and its place
  static constexpr size_t kCandidates = 3;       // places for a key frame, at most
  static constexpr int kNearSteps = 2;           // along edges of the covisibility graph: what is no further is near

  // Each place once: none shares 15 points with one before it. The far ones first, of these the best. None for a key
  // frame that is gone or has no words, or that comes soon after a loop.
  std::vector<KeyFrameId> candidates(const Map& map, KeyFrameId current) const;
  // Places in other submaps alone, by the same rule, and whenever the last loop was.
  static std::vector<KeyFrameId> candidates_elsewhere(const Map& map, KeyFrameId current);
  // A place was recognised by the key frame of this serial.
  void recognised(uint32_t serial) { last_loop_serial_ = serial; }
  void reset() { last_loop_serial_.reset(); }

 private:
  std::optional<uint32_t> last_loop_serial_;
};

}  // namespace covis
