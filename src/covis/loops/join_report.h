// SPDX-License-Identifier: Apache-2.0
// The report on making one map of many submaps: which pairs were joined, by which evidence, and why others were not.
#pragma once

#include <cstdint>
#include <vector>

#include "covis/geometry/sim3.h"
#include "covis/loops/loop_report.h"

namespace covis {

enum class JoinRefusal {
  none,          // the pair is joined
  not_alike,     // no key frame of one looks like a place of the other
  not_verified,  // none that does is verified: LoopRefusal says why
  unconfirmed,   // too few key frames claim to see the other submap
  too_small,     // one of both has too few key frames to differ from a place that looks the same
  ambiguous,     // claims contradict one another, as when one submap has two places that look like one of the other
  contradicted,  // key frames that would stand side by side do not see the same things
  inconsistent,  // both are joined with others, in another way than these claims say
};
const char* name(JoinRefusal refusal);

// Two submaps, by their ids before any was joined.
struct JoinedPair {
  uint32_t older = 0, younger = 0;
  JoinRefusal refusal = JoinRefusal::none;
  LoopRefusal why = LoopRefusal::none;      // not_verified: of the candidate that came furthest
  LoopEvidence evidence = {};               // that of the strongest claim, or of the candidate
  int claims = 0, contrary = 0;             // key frames that claim to see the other; claims on another relation
  int views_agree = 0, views_disagree = 0;  // views that would stand beside one of the other, once both are joined
  int views_contradict = 0;                 // those of the latter that see next to nothing of it
  Sim3 S_older_younger = {};                // from the younger one's world to the older one's, as first joined
  int fused = 0;                            // observations and points
};

// The cost of a bundle adjustment; 0: there was none. Of a submap that was adjusted in pieces the sum over these, in
// which what two of them see counts twice.
struct AdjustedCost {
  double before = 0, after = 0;
};

// A submap at the end.
struct JoinedMap {
  uint32_t id = 0;           // its submap in the map
  std::vector<uint32_t> of;  // the submaps that it was made of, by their ids before; rising
  double correction = 0;     // greatest move of a key frame by the pose graph, in the map's unit
  AdjustedCost cost = {};    // cost of the last bundle adjustment
};

struct JoinReport {
  std::vector<JoinedPair> pairs;  // all pairs of submaps, by their ids
  std::vector<JoinedMap> maps;    // by rising id
  double search_ms = 0, join_ms = 0, adjust_ms = 0;
};

}  // namespace covis
