// SPDX-License-Identifier: Apache-2.0
// Points of the current key frame's map paired with those of a place, as measurements for a similarity: S_12 takes the
// place's camera to the current one.
// Source: Mur-Artal, Montiel, Tardós, "ORB-SLAM", T-RO 2015, section VII-B.
#pragma once

#include <vector>

#include "covis/loops/loop_candidate.h"
#include "covis/matching/projection_match.h"
#include "covis/optimization/sim3_optimization.h"

namespace covis {

// Points of the current key frame against those of the place's members, by descriptor. None without members.
std::vector<Sim3Match> match_by_descriptor(const LoopCandidate& candidate);

// Both searches by projection together: `here` are points of the place that were found in the current view, of which
// those count that the current key frame has a point of its own for; `there` are points around the current key frame
// that were found in the view of the place, likewise. Each pair once. There must be a member.
std::vector<Sim3Match> match_both_ways(const LoopCandidate& candidate, const std::vector<PointMatch>& here,
                                       const std::vector<PointMatch>& there);

}  // namespace covis
