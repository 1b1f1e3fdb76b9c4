// SPDX-License-Identifier: Apache-2.0
// The loop closer's report on a key frame.
#pragma once

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
  not_seen_from_there,  // the place's key frames do not find the points here (joining submaps)
  drift_too_great,      // no drift explains the correction
};

// Counts of points.
struct LoopEvidence {
  int matches = 0;      // by descriptor
  int inliers = 0;      // matches that agree with a similarity
  int found_again = 0;  // points of the old place, in the new view
};

// The drift that the loop takes out of the map.
struct LoopDrift {
  double path = 0;          // travelled since that place, in the map's unit
  double distance = 0;      // between the key frame's place before and after, in the map's unit
  double rotation_deg = 0;  // between its orientations
  double scale = 1;         // by which lengths near the key frame were too great
};

// Milliseconds of each stage.
struct LoopTimes {
  double query = 0, verify = 0, correct = 0, pose_graph = 0;
};

struct LoopReport {
  LoopOutcome outcome = LoopOutcome::none;
  KeyFrameId loop;  // closed, joined: the key frame it was tied to
  int candidates = 0;
  LoopRefusal refusal = LoopRefusal::none;  // the reason for the last candidate that was refused
  LoopEvidence evidence;                    // the greatest numbers of any candidate
  LoopDrift drift;                          // by the last candidate that came so far
  int fused = 0;                            // points
  int joined_key_frames = 0;                // key frames of the submap that was moved
  LoopTimes ms;

  // The map was corrected or joined.
  bool changed_map() const { return outcome == LoopOutcome::closed || outcome == LoopOutcome::joined; }
};

}  // namespace covis
