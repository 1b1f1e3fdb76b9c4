// SPDX-License-Identifier: Apache-2.0
// Claims on a loop that want a second opinion, until another key frame says the same. A correction that drift cannot
// explain wants one by other points: one place alone may only look alike; two that agree on where the map went wrong
// count as evidence against the path between. A place that no key frame beside the current one sees wants any: the
// camera may have only just turned to it.
#pragma once

#include <cstdint>
#include <vector>

#include "covis/loops/loop_candidate.h"

namespace covis {

// Two opinions of where a camera is agree when their errors explain the difference, of the camera as one has it to as
// the other has it: to 10 % of the way between the places they come from and of the depth there, 5 degrees and a
// factor 1.2.
bool opinions_agree(const Sim3& difference, double way, double depth);

class LoopConsensus {
 public:
  enum class By { other_points, any_points };
  // True when an earlier claim of another key frame agrees with this one. It is kept in any case, until the map is
  // moved.
  bool confirms(const Map& map, KeyFrameId current, const Loop& claim, By by);
  void reset() { claims_.clear(); }

 private:
  struct Claim {
    uint32_t submap = 0, serial = 0;  // those of the key frame
    Sim3 S_there_here;                // from the world as the key frame has it to the place's
    std::vector<MapPointId> points;   // the place's points it found again, sorted
    By by = By::other_points;
  };

  std::vector<Claim> claims_;  // the newest last
  uint64_t moves_ = 0;         // Map::moves() of their time
};

}  // namespace covis
