// SPDX-License-Identifier: Apache-2.0
// The first pose of a map (algorithms.md §3.6).
#include <algorithm>

#include "covis/slam/tracker.h"

namespace covis {

void Tracker::initialise(Outcome& outcome) {
  has_velocity_ = false;
  if (monocular()) {
    initialise_monocular(outcome);
  } else {
    initialise_with_depth(outcome);
  }
}

void Tracker::initialise_with_depth(Outcome& outcome) {
  const TrackerOptions& o = options_.tracker;
  const Features& f = *current_.features;
  if (f.size() < o.init_features) {
    outcome.result.reason = "too few features for a first key frame";
    return;
  }
  KeyFrameRequest request;
  request.frame = current_.index;
  request.stamp = current_.stamp;
  request.features = current_.features;
  request.points.assign(current_.points.size(), {});
  for (uint32_t i = 0; i < static_cast<uint32_t>(f.size()); ++i) {
    if (f.depth[i] > 0) request.new_points.push_back(i);
  }
  if (static_cast<int>(request.new_points.size()) < o.min_close_points) {
    outcome.result.reason = "too few features with depth for a first key frame";
    return;
  }
  current_.T_cw = SE3();
  outcome.key_frame = std::move(request);
  begin_map(outcome.result);
}

void Tracker::initialise_monocular(Outcome& outcome) {
  outcome.initial_map = initializer_.offer(current_.features, current_.index, current_.stamp);
  outcome.result.predicted_matches = initializer_.matches();
  if (!outcome.initial_map) {
    outcome.result.reason = initializer_.reason();
    return;
  }
  initializer_.reset();
  begin_map(outcome.result);
}

// A map was asked for; key_frame_made() tells whether it holds.
void Tracker::begin_map(TrackResult& result) {
  state_ = TrackState::tracking;
  begun_frame_ = current_.index;
  last_key_frame_ = -1;
  last_key_frame_stamp_ = current_.stamp;
  // What was tried to find the frame in an older map is nothing to the new one.
  std::fill(current_.points.begin(), current_.points.end(), MapPointId{});
  std::fill(current_.known.begin(), current_.known.end(), kNone);
  result.reason = {};
  result.inliers = 0;
  result.method = TrackMethod::initialised;
  result.key_frame = true;
}

}  // namespace covis
