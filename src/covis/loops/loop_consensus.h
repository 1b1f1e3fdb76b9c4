// SPDX-License-Identifier: Apache-2.0
// Corrections that drift cannot explain, until another place says the same. One place alone may only look alike; two
// that are seen by different key frames, by other points, and that agree on where the map went wrong, count as evidence
// against the path between.
#pragma once

#include <cstdint>
#include <vector>

#include "covis/loops/loop_verifier.h"

namespace covis {

class LoopConsensus {
 public:
  // True when an earlier claim, of other points, agrees with this one. It is kept in any case, until the map is moved.
  bool confirms(const Map& map, KeyFrameId current, const Loop& claim);
  void reset() { claims_.clear(); }

 private:
  struct Claim {
    uint32_t submap = 0, serial = 0;  // of the key frame
    Sim3 S_there_here;                // from the world as the key frame has it to the place's
    std::vector<MapPointId> points;   // the place's points it found again, sorted
  };

  std::vector<Claim> claims_;  // the newest last
  uint64_t moves_ = 0;         // Map::moves() of their time
};

}  // namespace covis
