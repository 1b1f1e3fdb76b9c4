// SPDX-License-Identifier: Apache-2.0
// The state that a search for one frame's pose works on: the camera, the searches, the local map, the check of the
// place. Tracking and relocalisation share one, so that each continues with the results of the other.
#pragma once

#include <optional>
#include <vector>

#include "covis/core/time.h"
#include "covis/map/shared_map.h"
#include "covis/tracking/expected_view.h"
#include "covis/tracking/frame_matcher.h"
#include "covis/tracking/local_map.h"
#include "covis/tracking/place_check.h"
#include "covis/tracking/torn_image.h"
#include "covis/tracking/track_result.h"

namespace covis {

struct PoseSearch {
  Pinhole camera;
  FrameMatcher matcher;
  LocalMap local_map;
  ExpectedView view;
  PlaceCheck place;
  TornImage torn;
  std::vector<MapPointId> matched;  // work space of update_local_map()

  PoseSearch(const RecoveryOptions& options, Subject subject) : place(options, subject) {}

  // The map's camera may have been refined.
  void refresh_camera(const Map& map) { camera = map.camera(); }
  // Makes the local map anew around the frame's matches; around `fallback` when there are none.
  void update_local_map(const SharedMap& map, const TrackedFrame& frame, KeyFrameId fallback, int max_key_frames) {
    frame.map_points(matched);
    local_map.update(*map.read(), matched, fallback, max_key_frames);
  }
  // Searches the local map from the frame's pose so far, in windows wider by `factor`, and fits the pose to all
  // matches.
  void fit_local_map(const LocalMapOptions& o, double factor, TrackedFrame& frame, TrackFigures& figures) {
    Stopwatch watch;
    const MatchGate gate =
        MatchGate::local_map(o.local_window * factor, o.local_window_frontal * factor, o.local_ratio);
    figures.local_in_view = matcher.match_local_map(local_map, frame, camera, gate);
    figures.local_points = local_map.size();
    figures.ms.local_search += watch.lap();
    figures.inliers = matcher.fit_pose(frame, camera);
    figures.ms.pose += watch.ms();
    figures.local_expected = look(frame);
  }
  PlaceCheck::Found found(const TrackedFrame& frame, const SharedMap* live) const {
    return {frame, local_map, view.points(), live};
  }
  // Sees which points of the local map the frame should show at its pose, and returns how many usually match.
  double look(const TrackedFrame& frame) { return view.look(local_map, matcher.in_view(), frame, camera); }
};

}  // namespace covis
