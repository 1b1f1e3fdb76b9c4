// SPDX-License-Identifier: Apache-2.0
// The first pose of a map (algorithms.md §3.6), and the loss after which one is begun.
#include <algorithm>

#include "covis/core/log.h"
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
  if (f.size() < o.start.init_features) {
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
  if (static_cast<int>(request.new_points.size()) < o.key_frame.min_close_points) {
    outcome.result.reason = "too few features with depth for a first key frame";
    return;
  }
  current_.T_cw = SE3();
  outcome.key_frame = std::move(request);
  begin_map(outcome.result);
}

void Tracker::initialise_monocular(Outcome& outcome) {
  outcome.initial_map = initializer_.offer(camera_, current_.features, current_.index, current_.stamp);
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
  last_key_frame_stamp_ = current_.stamp;
  // What was tried to find the frame in an older map is nothing to the new one.
  std::fill(current_.points.begin(), current_.points.end(), MapPointId{});
  std::fill(current_.known.begin(), current_.known.end(), kNone);
  result.reason = {};
  result.inliers = 0;
  result.method = TrackMethod::initialised;
  result.key_frame = true;
}

void Tracker::lose(Outcome& outcome, bool map_is_live) {
  if (state_ != TrackState::lost) log(LogLevel::warning, std::string("tracking lost: ").append(outcome.result.reason));
  state_ = TrackState::lost;
  weak_ = options_.tracker.local_map.weak_inliers > 0;
  has_velocity_ = false;
  ++lost_frames_;
  if (!lost_since_) lost_since_ = current_.stamp;
  if (jumped_at_) last_place_.reset();  // no place to go on from
  take_back_jump();
  if (!map_is_live) return;
  constexpr int kYoungSubmapPatience = 15;  // frames it is waited for
  const std::optional<uint32_t> young = young_submap();
  if (young && lost_frames_ > kYoungSubmapPatience) {
    outcome.discard_submap = young;
    log(LogLevel::warning, "the initial map was lost at once and is given up; initialising again");
    beginning_ = map_.read()->submaps().size() > 1;
    if (!beginning_) state_ = TrackState::not_initialised;
    initializer_.reset();
    local_map_.clear();
    clear_counts();
    lost_frames_ = 0;
  } else if (beginning_ || (!young && new_map_due())) {
    if (!beginning_) {
      log(LogLevel::warning, reference_.valid() ? "lost for long: a new map is begun beside the old one"
                                                : "the loaded map is not found: a new one is begun beside it");
      initializer_.reset();
    }
    beginning_ = true;
    initialise(outcome);
  }
}

std::optional<uint32_t> Tracker::young_submap() const {
  constexpr size_t kYoungSubmap = 5;  // key frames
  if (!monocular()) return std::nullopt;
  const auto map = map_.read();
  const auto resolved = map->resolve(reference_);
  if (!resolved) return std::nullopt;
  const Submap& submap = *map->submap(map->at(resolved->key_frame).submap);
  if (submap.id < kept_submaps_ || submap.key_frames > kYoungSubmap) return std::nullopt;
  return submap.id;
}

// Without places recognised, or loops closed, both maps would never be joined.
bool Tracker::new_map_due() const {
  const double after = options_.tracker.start.new_map_after;
  return after > 0 && vocabulary_ && options_.loop.close && !options_.localize &&
         current_.stamp - *lost_since_ >= from_seconds(after);
}

}  // namespace covis
