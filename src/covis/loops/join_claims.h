// SPDX-License-Identifier: Apache-2.0
// Claims of key frames to see a place of another submap, when several maps are to become one: found by words and
// verified as LoopCloser verifies a join while running (loop_verifier.h). All key frames of all submaps are there, so
// that the claims on two submaps can be held against each other before one is believed.
#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include "covis/loops/key_frame_ways.h"
#include "covis/loops/loop_candidate.h"
#include "covis/loops/loop_options.h"
#include "covis/loops/loop_report.h"
#include "covis/map/map.h"

namespace covis {

// A place in another submap that a key frame shows, as it was verified. What it says is kept relative to the place's
// key frame, so that it holds when either submap is moved.
struct JoinClaim {
  KeyFrameId current, place;
  std::vector<std::pair<uint32_t, MapPointId>> matches;  // feature of the key frame, point of the place
  LoopEvidence evidence;

  JoinClaim(const Map& map, KeyFrameId current, const Loop& loop, const LoopEvidence& evidence);
  // The key frame as the place's submap has it now (Loop::S_cw).
  Sim3 S_cw(const Map& map) const;
  // From the world of the key frame's submap to that of the place's, as both are now.
  Sim3 S_there_here(const Map& map) const;
  // The median depth of the points, in the unit of the place's submap as it is now.
  double depth(const Map& map) const { return depth_ * map.at(place).scale / scale_there_; }

 private:
  Sim3 S_cp_;                                // from the place's camera to the current one
  double depth_ = 0;                         // at that time
  double scale_here_ = 1, scale_there_ = 1;  // KeyFrame::scale of both at that time
};

// A claim with its submaps in order, and the key frame of each.
struct JoinSides {
  KeyFrameId in_older, in_younger;
  Sim3 S_old_young;  // from the world of the younger submap to that of the older
  double depth = 0;  // median depth of the points, in the older one's unit

  JoinSides(const Map& map, const JoinClaim& claim);
};

struct JoinClaims {
  std::vector<JoinClaim> claims;       // by rising serial of the key frame
  std::vector<RefusedPlace> refused;   // likewise; the submaps are those of `refused_of` and of the place
  std::vector<KeyFrameId> refused_of;  // the key frame of each
  std::vector<uint32_t> metric;        // the submaps whose lengths are metres; rising

  bool is_metric(uint32_t submap) const { return std::binary_search(metric.begin(), metric.end(), submap); }

  // Asks every key frame of the map.
  static JoinClaims collect(const Map& map, Sensor sensor, const LoopOptions& options, int seed);
};

// Claims between two submaps that agree with one another on how these lie: with at least one of the others to what the
// way between both explains. The submaps are those of `older` and `younger`.
struct JoinGroup {
  uint32_t older = 0, younger = 0;
  std::vector<size_t> claims;  // indices, the strongest (most points found again) first
};

// All groups, those of the most claims first. Equal ones by their submaps. `ways` are the map's.
std::vector<JoinGroup> group_claims(const Map& map, const KeyFrameWays& ways, const std::vector<JoinClaim>& claims);

}  // namespace covis
