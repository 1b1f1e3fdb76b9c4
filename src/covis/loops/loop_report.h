// SPDX-License-Identifier: Apache-2.0
// The loop closer's report on a key frame.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "covis/core/ids.h"

namespace covis {

enum class LoopOutcome {
  none,    // no place was recognised
  fused,   // a place was seen again, and there was no drift to take out
  closed,  // the map was bent
  joined,  // two submaps became one
};

// Why a candidate is no loop: the first criterion it fails.
enum class LoopRefusal {
  none,
  few_matches,          // by descriptor
  no_similarity,        // RANSAC, or its refinement, keeps too few matches
  not_found_again,      // too few of the place's points
  small_share,          // they are too few of those in view
  tied_already,         // more than half of them are points the key frame has anyway
  neighbours_disagree,  // the key frames beside it do not find the place's points
  not_seen_from_there,  // the place's key frames do not find the points here
  drift_too_great,      // no drift explains the correction
  unconfirmed,          // no drift explains it, the path since has a weak link, and no other place has agreed
};
const char* name(LoopRefusal refusal);

// Counts of points.
struct LoopEvidence {
  int matches = 0;      // by descriptor
  int inliers = 0;      // matches that agree with a similarity
  int both_ways = 0;    // matches by projection, from there to here and from here to there, that agree with it
  int found_again = 0;  // points of the old place, in the new view
  int in_view = 0;      // those that should be

  // The greater of each number.
  void raise_to(const LoopEvidence& other);
};

// The drift that the loop takes out of the map.
struct LoopDrift {
  double path = 0;      // travelled since that place, in the map's unit
  double past = 0;      // how far the scene moved past the camera since, by the path and by turns, in the map's unit
  double distance = 0;  // between the key frame's place before and after, in the map's unit
  double rotation_deg = 0;  // between its orientations
  double scale = 1;         // by which lengths near the key frame were too great
};

// A candidate that was no loop.
struct RefusedPlace {
  KeyFrameId place;
  int64_t frame = 0;  // in which that key frame was seen
  LoopRefusal why = LoopRefusal::none;
  LoopEvidence evidence;
  std::optional<LoopDrift> drift;  // when it came so far
  std::optional<int> link;         // points across the weakest link of the path since; when it was asked
};
// Names the place, the reason and the figures.
std::string describe(const RefusedPlace& refused);

// Milliseconds of each stage.
struct LoopTimes {
  double query = 0, verify = 0, correct = 0, pose_graph = 0;
};

// A submap that was moved into the world of another and became a part of it.
struct JoinedSubmap {
  uint32_t id = 0;    // no submap has it any more
  uint32_t kept = 0;  // the other, which may be joined to another later
  int key_frames = 0;
};

struct LoopReport {
  LoopOutcome outcome = LoopOutcome::none;
  KeyFrameId loop;  // closed, joined: the key frame it was tied to
  int candidates = 0;
  std::vector<RefusedPlace> refused;  // in the order in which they were asked
  LoopEvidence evidence;              // the loop's; without one the greatest numbers of any candidate
  LoopDrift drift;                    // the loop's; without one that of the last candidate that came so far
  bool confirmed = false;             // the loop was a claim, and two key frames agree on it
  bool unexplained = false;           // no drift explains its correction
  int fused = 0;                      // points
  int new_edges = 0;                  // closed: edges that the pose graph got from points fused
  std::optional<JoinedSubmap> joined;
  LoopTimes ms;

  // The map was corrected or joined.
  bool changed_map() const { return outcome == LoopOutcome::closed || outcome == LoopOutcome::joined; }
};

}  // namespace covis
