// SPDX-License-Identifier: Apache-2.0
// The searches that match a frame with known points, and the pose that follows from the matches. Every search writes
// the frame's matches and returns how many there are. Source: Mur-Artal, Montiel, Tardós, "ORB-SLAM", T-RO 2015,
// sections V-B and V-D; Mur-Artal and Tardós, "ORB-SLAM2", T-RO 2017, III-C.
#pragma once

#include <vector>

#include "covis/map/key_frame_view.h"
#include "covis/matching/descriptor_match.h"
#include "covis/matching/projection_match.h"
#include "covis/optimization/pose_optimization.h"
#include "covis/tracking/local_map.h"
#include "covis/tracking/tracked_frame.h"

namespace covis {

// Keeps its work space between frames: only the searches by descriptor alone, and
// find_pose(), allocate in a steady state.
class FrameMatcher {
 public:
  FrameMatcher();

  // Searches the points that the last frame showed around where frame.T_cw expects them, in windows of `window` pixels
  // x scale.
  struct LastFrameMatches {
    int in_view = 0;  // points of the last frame expected in the image
    int matches = 0;
  };
  LastFrameMatches match_last_frame(const TrackedFrame& last, TrackedFrame& frame, const Pinhole& camera,
                                    double window);
  // Matches the points that the last frame showed by descriptor alone.
  static int match_frame(const TrackedFrame& last, TrackedFrame& frame, const DescriptorMatchOptions& options);
  // Matches the points of a key frame by descriptor alone.
  static int match_key_frame(const KeyFrameView& view, TrackedFrame& frame, const DescriptorMatchOptions& options);
  // Searches the points of the local map that are not matched yet and keeps the matches there are. Returns how many
  // points of the local map are in view, matched ones among them.
  int match_local_map(const LocalMap& local_map, TrackedFrame& frame, const Pinhole& camera, const MatchGate& gate);

  // Finds frame.T_cw from its matches alone, by P3P in RANSAC, and drops those that disagree. False when too few agree.
  static bool find_pose(TrackedFrame& frame, const Pinhole& camera, int seed);
  // Optimises frame.T_cw over its matches and drops those that disagree. Returns how many map points agree; 0 without a
  // pose. The map's points lead, without the new ones where enough are left.
  int fit_pose(TrackedFrame& frame, const LocalMap& local_map, const Pinhole& camera);

  // A flag for each point of the local map: it was in view of the last match_local_map().
  const std::vector<uint8_t>& in_view() const { return projection_.in_view(); }

 private:
  ProjectionMatcher projection_;
  PointSet seen_;                   // the last frame's points
  std::vector<uint32_t> seen_by_;   // for each of them its feature in the last frame
  std::vector<float> seen_angle_;   // the orientation of that feature, radians
  std::vector<double> seen_depth_;  // metres, in the last camera
  MatchedPoints matched_;
  std::vector<uint8_t> known_, taken_;  // flags: points and features matched before a search of the local map
  PoseObservations observations_;
  std::vector<uint32_t> observed_by_;  // for each observation its feature
  std::vector<uint8_t> inlier_;
};

}  // namespace covis
