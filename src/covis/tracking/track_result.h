// SPDX-License-Identifier: Apache-2.0
// The result of tracking one frame.
#pragma once

#include <cstdint>
#include <string_view>

#include "covis/map/relative_pose.h"
#include "covis/types.h"

namespace covis {

// The source of a tracked frame's first pose. `dead_reckoned`: in localisation only, from the last frame's own depth
// where the map has too few points. `backtracked`: afterwards, from a later frame (backtrack.h).
enum class TrackMethod {
  none,
  initialised,
  motion_model,
  image_rotation,
  last_frame,
  reference_key_frame,
  recovered,
  dead_reckoned,
  backtracked
};

constexpr std::string_view name(TrackMethod method) {
  switch (method) {
    case TrackMethod::none:
      return "none";
    case TrackMethod::initialised:
      return "initialised";
    case TrackMethod::motion_model:
      return "motion_model";
    case TrackMethod::image_rotation:
      return "image_rotation";
    case TrackMethod::last_frame:
      return "last_frame";
    case TrackMethod::reference_key_frame:
      return "reference_key_frame";
    case TrackMethod::recovered:
      return "recovered";
    case TrackMethod::dead_reckoned:
      return "dead_reckoned";
    case TrackMethod::backtracked:
      return "backtracked";
  }
  return "";
}

// The times of tracking one frame, milliseconds.
struct TrackTimes {
  double motion = 0;        // first pose: search and optimisation
  double local_update = 0;  // copying the local map
  double local_search = 0;  // searching it
  double pose = 0;          // last pose optimisation
  double align = 0;         // refining the places of matches, and the pose by them
};

// What of a frame, or of its map, is not to be believed. While there is something the frame's pose is tentative.
struct FrameDoubts {
  // DepthAgainstMap::error where depth contradicts the map, so that the pose is of the image alone; 0: it does not.
  double depth_contradiction = 0;
  bool torn = false;  // some rows of the image are displaced (torn_image.h): nothing is mapped from it
  // Its map was begun because depth contradicted the one before, and may be as wrong (DepthBelief).
  bool map_on_probation = false;

  bool any() const { return torn || depth_contradiction > 0 || map_on_probation; }
};

// The figures of tracking one frame.
struct TrackFigures {
  TrackMethod method = TrackMethod::none;
  int features = 0;           // keypoints of the frame
  int predicted_matches = 0;  // matches from which the first pose was made
  double first_share = 0;     // share of the last frame's points in view that agree with the first pose
  int local_points = 0;       // points of the local map
  int local_in_view = 0;      // points of it predicted in view
  double local_expected = 0;  // how many of those are expected to match
  int inliers = 0;         // map points that agree with the pose, or, of a lost frame, with the last one that was tried
  bool tentative = false;  // the camera came here by a jump or by few matches, less than a second ago, or doubts.any()
  FrameDoubts doubts;
  bool key_frame = false;  // a key frame was asked for
  TrackTimes ms;
};

struct TrackResult : TrackFigures {
  TrackingState state = TrackingState::not_initialised;
  NoPoseReason reason = NoPoseReason::none;  // none when tracking
  SE3 T_cw;                                  // meaningful when tracking
  Matrix6d information = Matrix6d::Zero();   // of T_cw, given the map; 0 for the frame that begins a submap
  RelativePose pose;                         // the same relative to its reference key frame
  ShutterResponse shutter;                   // corrects `pose`
  uint64_t moves = 0;                        // Map::moves() when it was tracked
  uint32_t submap = 0;                       // id of its submap: poses of different submaps have different worlds
};

}  // namespace covis
