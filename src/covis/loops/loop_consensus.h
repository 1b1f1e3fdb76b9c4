// SPDX-License-Identifier: Apache-2.0
// Claims on a loop that want a second opinion, until another key frame says the same. A correction that drift cannot
// explain wants one by other points: one place alone may only look alike; two that agree on where the map went wrong
// count as evidence against the path between. A place that no key frame beside the current one sees wants any, soon:
// the camera may have only just turned to it.
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
  // True when an earlier claim of another key frame agrees with this one, as the map is now. It is kept in any case.
  // One by other points is good until the map is moved: its points may have become others since.
  bool confirms(const Map& map, KeyFrameId current, const Loop& claim, By by);
  void reset() { claims_.clear(); }

 private:
  struct Claim {
    KeyFrameId here, there;                  // the key frame, and the place's
    Sim3 S_here_there;                       // between their cameras, in the units of then
    double scale_here = 1, scale_there = 1;  // KeyFrame::scale of both
    uint64_t moves = 0;                      // Map::moves()
    std::vector<MapPointId> points;          // the place's points it found again, sorted
    By by = By::other_points;

    // From the world as the key frame has it to the place's.
    Sim3 correction(const Map& map) const;
  };
  static bool agree(const Map& map, const Claim& earlier, const Claim& now, double depth);

  std::vector<Claim> claims_;  // the newest last
};

}  // namespace covis
