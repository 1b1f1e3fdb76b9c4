// SPDX-License-Identifier: Apache-2.0
// The state that a search for one frame's pose works on: the camera, the searches, the local map, the check of the
// place. Tracking and relocalisation share one, so that each continues with the results of the other.
#pragma once

#include <optional>
#include <utility>
#include <vector>

#include "covis/core/time.h"
#include "covis/map/shared_map.h"
#include "covis/tracking/expected_view.h"
#include "covis/tracking/frame_matcher.h"
#include "covis/tracking/local_map.h"
#include "covis/tracking/match_alignment.h"
#include "covis/tracking/match_belief.h"
#include "covis/tracking/moving_features.h"
#include "covis/tracking/place_check.h"
#include "covis/tracking/rolling_shutter.h"
#include "covis/tracking/torn_image.h"
#include "covis/tracking/track_result.h"

namespace covis {

struct PoseSearch {
  Pinhole camera;
  FrameMatcher matcher;
  MatchAlignment alignment;
  RollingShutter shutter;
  LocalMap local_map;
  ExpectedView view;
  PlaceCheck place;
  TornImage torn;
  MovingFeatures moving;
  const ImageProbe* image = nullptr;  // looks at the image whose frame is searched; null: it is gone
  std::vector<MapPointId> matched;    // work space of update_local_map()
  TrackedFrame unfitted;              // kept by Tracker: the frame before fit_local_map()

  PoseSearch(const RecoveryOptions& options, Subject subject, const ShutterOptions& images = {})
      : shutter(images), place(options, subject) {}

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
    figures.inliers = matcher.fit_pose(frame, local_map, camera);
    figures.ms.pose += watch.ms();
    figures.local_expected = look(frame);
  }
  // After fit_local_map() with the same arguments, of a frame that `unfitted` kept before: does it once more, from the
  // predicted pose and without the matches of the first pose, at first in windows twice as wide. A first pose fitted to
  // a few points side by side may be off by degrees, so that all others are missed (docs/notes/047-a-second-start.md).
  // The frame and its figures stay as they were unless clearly more points agree, enough to be believed by themselves,
  // at a pose that is nearer to the predicted one.
  void fit_local_map_from(const SE3& predicted_cw, const LocalMapOptions& o, double factor, const MatchBelief& belief,
                          TrackedFrame& frame, TrackFigures& figures) {
    constexpr double kWider = 2, kBetter = 1.2;
    const SE3 first_cw = frame.T_cw;
    const int inliers = figures.inliers;
    const double first_share = std::exchange(figures.first_share, 0);  // it speaks for the first pose
    frame.clear_matches();
    frame.T_cw = predicted_cw.normalized();
    fit_local_map(o, kWider * factor, frame, figures);
    fit_local_map(o, factor, frame, figures);
    const auto off = [&](const SE3& T_cw) {  // radians, about
      const Vector6d step = (T_cw * predicted_cw.inverse()).log();
      return step.tail<3>().norm() + step.head<3>().norm() / frame.mean_depth();
    };
    const bool believed = figures.inliers >= o.min_inliers && belief.explains_view(figures, false);
    if (believed && figures.inliers > kBetter * inliers && off(frame.T_cw) < off(first_cw)) return;
    unfitted.features = std::move(frame.features);
    std::swap(frame, unfitted);
    figures.first_share = first_share;
    fit_local_map(o, factor, frame, figures);
  }
  PlaceCheck::Found found(const TrackedFrame& frame, const SharedMap* live) const {
    return {frame, local_map, view.points(), live, image};
  }
  // Sees which points of the local map the frame should show at its pose, and returns how many usually match.
  double look(const TrackedFrame& frame) { return view.look(local_map, matcher.in_view(), frame, camera); }
};

}  // namespace covis
