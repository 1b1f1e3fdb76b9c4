// SPDX-License-Identifier: Apache-2.0
// Loop closing: recognises that a new key frame sees a place mapped before, and bends the map so that both are one.
// Synchronous; works on copies and commits under short write guards. Called by the mapping thread after local mapping
// of a key frame, so that there is one writer of the map.
//
// A false loop is worse than a missed one. A loop is taken only when
//   1. the words of both places are alike (the database's query; at least as alike as the key frame's worst neighbour),
//   2. RANSAC finds a similarity that at least 20 matched points agree with, and its refinement keeps 20,
//   3. the old place's points, projected by it, are found again: 40 at least, and a share of all that are in view; most
//      of them not points the key frame has anyway,
//   4. the neighbours of the key frame, moved along, find the old place's points too,
//   5. the correction is one that drift can explain: a share of the path travelled since. What looks alike but is
//      another place (the same poster on two walls, two equal rooms) fails here.
// A place in another submap joins the two submaps. Of their relation nothing is known that drift could explain,
// so that tests 3 and 4 ask for more instead, and the old place's views must find the new one's points as well.
//
// Sources: Mur-Artal, Montiel, Tardós, "ORB-SLAM", T-RO 2015, section VII; verification at once by several covisible
// key frames: Campos et al., "ORB-SLAM3", T-RO 2021, section VI (merging of maps, too); Strasdat et al., RSS 2010 (pose
// graph over Sim(3)).
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "covis/geometry/sim3.h"
#include "covis/map/shared_map.h"
#include "covis/map/key_frame_view.h"
#include "covis/matching/projection_match.h"
#include "covis/optimization/pose_optimization.h"
#include "covis/optimization/sim3_optimization.h"
#include "covis/slam/messages.h"
#include "covis/slam/options.h"
#include "covis/matching/point_fuser.h"

namespace covis {

class LoopCloser {
 public:
  LoopCloser(SharedMap& map, const SystemOptions& options) : map_(map), options_(options) {}

  // Looks whether `current`, just mapped, closes a loop or joins its submap to another, and does it. True when
  // the map was corrected or joined.
  bool process(KeyFrameId current, LoopReport& report);
  void reset() { last_loop_serial_.reset(); }

 private:
  // The place a loop leads to, copied out of the map: a key frame and those round it.
  struct Place {
    KeyFrameId key_frame;
    SE3 T_cw;
    std::vector<KeyFrameId> group;   // the key frame first
    PointSet points;                 // of the group, in the order of handles
  };
  using View = KeyFrameView;  // the key frame in question, likewise
  struct Found {
    Place place;
    bool elsewhere = false;                                // the place is of another submap
    Sim3 S_cw;                                             // the current key frame as the old place's map would have it
    std::vector<std::pair<uint32_t, MapPointId>> matches;  // feature of the current key frame, point of the place
  };
  // Which of the place's points were found in a view at a pose.
  struct Projection {
    int in_view = 0;
    std::vector<PointMatch> matches;
  };

  std::vector<KeyFrameId> candidates(const Map& map, KeyFrameId current) const;
  Place copy_place(const Map& map, KeyFrameId id) const;
  std::optional<Found> verify(const View& current, KeyFrameId candidate, LoopReport& report);
  std::vector<Sim3Match> match_points(const View& current, const Place& place) const;
  Projection project(const Place& place, const View& view, const SE3& T_cw, double window);
  // Refines the pose on the matches and keeps those that agree.
  bool refine(const Place& place, const View& view, SE3& T_cw, Projection& projection) const;
  static bool tied_already(const View& current, const Place& place, const Projection& projection);
  bool enough_for_neighbour(const Projection& projection) const;
  bool neighbours_agree(const Map& map, const View& current, const Found& found);
  bool seen_from_there(const Map& map, const View& current, const Found& found);
  bool drift_explains(const Map& map, const View& current, const Found& found, LoopReport& report) const;
  bool nothing_to_correct(const Found& found, const LoopReport& report) const;
  void correct(const View& current, const Found& found, LoopReport& report);
  bool join(const View& current, const Found& found, LoopReport& report);  // false: refused by the map
  void fuse(const View& current, const Found& found, LoopReport& report);

  bool monocular() const { return options_.sensor == Sensor::monocular; }

  SharedMap& map_;
  const SystemOptions options_;
  std::optional<uint32_t> last_loop_serial_;
  Pinhole camera_;  // the map's
  ProjectionMatcher matcher_;
  PointFuser fuser_;
};

}  // namespace covis
