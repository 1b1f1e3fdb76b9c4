// SPDX-License-Identifier: Apache-2.0
// Tells a place seen again from one that only looks alike. Works on copies, without the map.
//
// A false loop is worse than a missed one. A candidate, whose words are alike (loop_detector.h), is taken only when
//   1. at least 20 points of both places match by descriptor,
//   2. RANSAC finds a similarity that at least 20 of them agree with, and its refinement keeps 20,
//   3. the old place's points, projected by it, are found again: 40 at least, and a share of all that are in view; most
//      of them not points the key frame has anyway,
//   4. the neighbours of the key frame, moved along, find the old place's points too,
//   5. the correction is one that drift can explain: a share of how far the scene moved past the camera since. What
//      looks alike but is another place (the same poster on two walls, two equal rooms) fails here. What fails here
//      alone is a claim, for LoopConsensus to judge, if it passes the tests of places in another submap; so is what
//      fails test 4 alone, if the old place's views find the new one's points.
// A place in another submap joins the two submaps. Their relation is unknown, so that no drift could explain it: tests
// 3 and 4 ask for more instead, and the old place's views must find the new one's points as well. When saved maps are
// merged, a view passes tests 3 and 4 also with a smaller share, where it shows as much as was seen from about there
// before (expected_matches.h): in a crowded place most of what lies in the view's cone is covered from there.
//
// Sources: Mur-Artal, Montiel, Tardós, "ORB-SLAM", T-RO 2015, section VII-B; verification at once by several covisible
// key frames: Campos et al., "ORB-SLAM3", T-RO 2021, section VI (merging of maps, too).
#pragma once

#include <optional>
#include <vector>

#include "covis/loops/loop_candidate.h"
#include "covis/loops/loop_options.h"
#include "covis/loops/loop_report.h"
#include "covis/matching/expected_matches.h"
#include "covis/matching/projection_match.h"
#include "covis/optimization/sim3_optimization.h"

namespace covis {

struct LoopVerdict {
  LoopRefusal refusal = LoopRefusal::none;
  LoopEvidence evidence;
  std::optional<LoopDrift> drift;  // when it came so far
  std::optional<Loop> loop;        // when it was accepted
  std::optional<Loop> claim;       // when it was refused for its neighbours or its drift alone
};

class LoopVerifier {
 public:
  LoopVerifier(Sensor sensor, const LoopOptions& options, int seed) : sensor_(sensor), options_(options), seed_(seed) {}
  // To merge saved maps. The map must not change while this lives.
  LoopVerifier(const Map& map, Sensor sensor, const LoopOptions& options, int seed)
      : sensor_(sensor), options_(options), seed_(seed), map_(&map) {}

  LoopVerdict verify(const LoopCandidate& candidate);

  enum class View { agrees, disagrees, contradicts, says_nothing };
  // A view at a pose in the place's world is asked whether it sees the place: it finds as much of it as a neighbour of
  // the key frame must (test 4), or does not, or next to nothing of what was seen from there before (only when maps are
  // merged), or has too little of it in view to tell.
  View look_for(const LoopPlace& place, const Pinhole& camera, const KeyFrameView& view, const SE3& T_cw);

 private:
  // The place's points that were found in a view at a pose.
  struct Projection {
    int in_view = 0;
    std::vector<PointMatch> matches;
    SE3 T_cw;
    std::vector<uint8_t> visible = {};  // a flag for each point of the place; when maps are merged

    int count() const { return static_cast<int>(matches.size()); }
    double share() const { return in_view > 0 ? static_cast<double>(count()) / in_view : 0; }
  };

  std::optional<Sim3> similarity(const std::vector<Sim3Match>& matches, const LoopCandidate& candidate,
                                 LoopEvidence& evidence) const;
  // Finds the place's points in the current view, refining its pose and scale; nothing when they are too few.
  std::optional<Projection> find_again(const LoopCandidate& candidate, Sim3& S_cw, LoopEvidence& evidence);
  // Refines the similarity on the points that were found here, and on those around here that are found there.
  void refine_both_ways(const LoopCandidate& candidate, const Projection& here, double window, Sim3& S_cw,
                        LoopEvidence& evidence);
  // Returns what all views of both sides know of the similarity, CarriedResult::information, if they agree. By one
  // camera they refine it, its scale too: the current one may see a corner of the place alone.
  std::optional<Matrix7d> refine_on_views(const LoopCandidate& candidate, Sim3& S_cw);
  Projection project(const LoopPlace& place, const Pinhole& camera, const KeyFrameView& view, const SE3& T_cw,
                     double window);
  ExpectedMatches expected(const LoopPlace& place, const Projection& projection) const;
  // The projection finds such a share of the place's points in view, or what is expected.
  bool shows_enough(const LoopPlace& place, const Projection& projection, double share) const;
  bool enough_for_neighbour(const LoopPlace& place, const Projection& projection) const;
  bool neighbours_agree(const LoopCandidate& candidate, const Sim3& S_cw);
  // The first `views` views of the place find the points around the current key frame.
  bool seen_from_there(const LoopCandidate& candidate, const Sim3& S_cw, size_t views);
  bool drift_explains(const LoopDrift& drift) const;

  bool monocular() const { return sensor_ == Sensor::monocular; }
  Scale scale() const { return monocular() ? Scale::free : Scale::fixed; }

  const Sensor sensor_;
  const LoopOptions options_;
  const int seed_;
  const Map* map_ = nullptr;  // only to merge maps: knows from where each point was seen
  ProjectionMatcher matcher_;
};

// Replaces the similarity of a loop in the same submap, once, by the most probable one, given the drift that was to be
// expected (drift_prior.h). Where the views do not agree it stays. Returns the drift that the loop then takes out.
LoopDrift weigh_against_drift(const LoopCandidate& candidate, Sensor sensor, Loop& loop);

// A place seen again whose correction would move its points by no more than two pixels: the camera looked away for a
// moment. Its points are to be fused, but there is no drift to take out.
bool nothing_to_correct(const Loop& loop, const Pinhole& camera);

}  // namespace covis
