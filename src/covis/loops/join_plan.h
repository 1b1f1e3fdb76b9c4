// SPDX-License-Identifier: Apache-2.0
// Decides which submaps are joined, before any is moved. One claim may be mistaken, and a false join ties two places
// together for good; with both maps whole there is more to ask than while running. A pair is joined when
//   1. three pairs of key frames at least claim to see the same place, and agree on how both submaps lie, each of which
//      has five key frames at least,
//   2. fewer than half as many claims say otherwise: else one submap has two places that look like one of the other,
//      and nobody can tell which it is. Key frames of such claims are not believed about other submaps either, whose
//      claims are counted again without them,
//   3. where key frames of both would stand side by side, and so must see the same, they do, rather than not; where
//      more than a quarter do not, five claims must agree; and at most one in twenty sees next to nothing of what the
//      other submap saw from there. Two rooms that are equal in everything differ behind their doors.
#pragma once

#include <vector>

#include "covis/loops/join_claims.h"
#include "covis/loops/join_report.h"
#include "covis/loops/loop_verifier.h"

namespace covis {

struct JoinPlan {
  std::vector<JoinGroup> groups;  // those that are believed, the surest (of the most claims) first
  std::vector<JoinedPair> pairs;  // all pairs of submaps, by their ids, with what was decided

  JoinPlan(const Map& map, const JoinClaims& found, LoopVerifier& verifier);
};

// Counts key frames of either submap that would stand beside one of the other, near the group's claims: those that see
// the same, those that do not, and of these the ones that see next to nothing of it.
struct SideBySide {
  int agree = 0, disagree = 0, contradict = 0;

  SideBySide(const Map& map, const KeyFrameWays& ways, const JoinClaims& found, const JoinGroup& group,
             LoopVerifier& verifier);

 private:
  // A claim as one side has it.
  struct Link {
    KeyFrameId here;
    Sim3 S_there_here;  // from the world of its submap to that of the other
    double depth = 0;   // median depth of the points, in the other one's unit
  };
  void look(const Map& map, const KeyFrameWays& ways, const Pinhole& camera, uint32_t from, uint32_t to,
            const std::vector<Link>& links, LoopVerifier& verifier);
};

}  // namespace covis
