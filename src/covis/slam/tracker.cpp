// SPDX-License-Identifier: Apache-2.0
#include "covis/slam/tracker.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "covis/core/log.h"
#include "covis/core/reserve.h"
#include "covis/matching/descriptor_match.h"
#include "covis/matching/point_geometry.h"

namespace covis {
namespace {

struct NearerFeature {
  const Features& f;
  bool operator()(uint32_t a, uint32_t b) const { return f.depth[a] != f.depth[b] ? f.depth[a] < f.depth[b] : a < b; }
};

}  // namespace

void TrackedFrame::start(FeaturesPtr f, int64_t frame, Timestamp t) {
  features = std::move(f);
  index = frame;
  stamp = t;
  const auto n = static_cast<size_t>(features->size());
  reserve_ahead(points, n);
  reserve_ahead(positions, n);
  reserve_ahead(known, n);
  points.assign(n, {});
  positions.resize(n);
  known.assign(n, 0);
}

int TrackedFrame::map_points() const { return static_cast<int>(std::count(known.begin(), known.end(), kMapPoint)); }

Tracker::Tracker(const SharedMap& map, const SystemOptions& options, std::shared_ptr<const Vocabulary> vocabulary)
    : map_(map), options_(options), vocabulary_(std::move(vocabulary)), initializer_(options) {
  // Room in advance, memory for which is used only when points come.
  constexpr size_t kPointSlots = 1 << 17, kLocalPoints = 1 << 14, kFeatures = 1 << 12;
  counts_.reserve(kPointSlots);
  counted_.reserve(kPointSlots);
  matched_mark_.reserve(kPointSlots);
  match_.reserve(kLocalPoints);
  queries_.reserve(kLocalPoints);
  query_source_.reserve(kLocalPoints);
  observations_.reserve(kFeatures);
  observed_feature_.reserve(kFeatures);
}

std::optional<Tracker::Located> Tracker::locate(FeaturesPtr features, int64_t frame) {
  current_.start(std::move(features), frame, 0);
  refresh_camera(*map_.read());
  TrackResult result;
  if (!recover(result, true)) return std::nullopt;
  return Located{current_.T_cw, local_map_.reference.submap};
}

void Tracker::start_lost() {
  state_ = TrackState::lost;
  weak_ = options_.tracker.local_map.weak_inliers > 0;
  has_velocity_ = false;
  const auto map = map_.read();
  refresh_camera(*map);
  kept_submaps_ = map->submaps().empty() ? 0 : map->submaps().back().id + 1;
  last_ = {};
  last_place_.reset();
  jumped_at_.reset();
  reference_ = new_reference_ = {};
  local_map_.clear();
  clear_counts();
}

double Tracker::close_depth() const { return options_.tracker.key_frame.close_depth_baselines * camera_.baseline(); }

Tracker::Outcome Tracker::track(FeaturesPtr features, int64_t frame, Timestamp stamp, bool map_is_live,
                                bool mapping_idle) {
  current_.start(std::move(features), frame, stamp);
  Outcome outcome;
  TrackResult& result = outcome.result;
  result.features = current_.features->size();
  if (state_ == TrackState::not_initialised) {
    refresh_camera(*map_.read());
    initialise(outcome);
  } else {
    if (map_is_live && (map_changed_ || options_.realtime)) {
      refresh_last_frame(*map_.read());
      map_changed_ = false;
    }
    bool found = find_pose(result, map_is_live);
    // In real time a loop may have been closed meanwhile: what was read before does not fit what was read after.
    for (int again = 0; found && options_.realtime && map_.read()->moves() != moves_; ++again) {
      refresh_last_frame(*map_.read());
      found = again < 2 && find_pose(result, map_is_live);
    }
    if (found) {
      accept(result);
      if (key_frame_due(result, mapping_idle)) {
        outcome.key_frame = make_key_frame_request();
        result.key_frame = true;
      }
    } else {
      lose(outcome, map_is_live);
    }
  }
  result.state = state_;
  near_loss_ = result.inliers < 2 * options_.tracker.local_map.min_inliers;
  outcome.retract_from = std::exchange(retract_from_, std::nullopt);
  std::swap(last_, current_);
  return outcome;
}

bool Tracker::find_pose(TrackResult& result, bool map_is_live) {
  constexpr int kTryEvery = 5;  // bridged frames
  bool found = false;
  if (state_ == TrackState::tracking) {
    // What is bridged drifts: the map is looked for again and again.
    if (dead_reckoned_frames_ > 0 && dead_reckoned_frames_ % kTryEvery == 0 && recover(result, map_is_live)) return true;
    found = track_by_motion(result) || track_by_reference(result);
    found = found && (track_local_map(result, map_is_live) || bridge(result));
  }
  return found || recover(result, map_is_live);
}

bool Tracker::bridge(TrackResult& result) {
  if (!may_bridge() || all_inliers() < options_.tracker.local_map.min_inliers) return false;
  ++dead_reckoned_frames_;
  result.method = TrackMethod::dead_reckoned;
  return true;
}

int Tracker::all_inliers() const {
  return static_cast<int>(
      std::count_if(current_.known.begin(), current_.known.end(), [](uint8_t k) { return k != kNone; }));
}

void Tracker::accept(TrackResult& result) {
  count_points();
  const bool same_submap = local_map_.reference.submap == submap_;
  has_velocity_ = state_ == TrackState::tracking && current_.stamp > last_.stamp && same_submap;
  if (has_velocity_) {
    velocity_ = (current_.T_cw * last_.T_cw.inverse()).normalized();
    velocity_time_ = current_.stamp - last_.stamp;
  }
  state_ = TrackState::tracking;
  lost_frames_ = 0;
  beginning_ = false;
  if (jumped_at_ && !lately(jumped_at_->stamp)) jumped_at_.reset();
  if (!jumped_at_) lost_since_.reset();
  if (result.method != TrackMethod::dead_reckoned) dead_reckoned_frames_ = 0;
  // Twice the features give more inliers by themselves: the way back asks for more than that.
  const int weak = options_.tracker.local_map.weak_inliers;
  weak_ = weak_ ? 2 * result.inliers < 5 * weak : result.inliers < weak;
  reference_ = local_map_.reference.id;
  reference_scale_ = local_map_.reference.scale;
  submap_ = local_map_.reference.submap;
  last_T_cr_ = current_.T_cw * local_map_.reference.T_cw.inverse();
  last_place_ = current_.T_cw;
  result.tentative = jumped_at_.has_value();
  result.T_cw = current_.T_cw;
  result.pose = {reference_, reference_scale_, last_T_cr_};
  result.submap = submap_;
  result.reason = {};
}

void Tracker::key_frame_made(const KeyFrameMade& report) {
  map_changed_ = true;
  const bool first = report.frame == begun_frame_;  // of a map; reports of older key frames may come before it
  if (!report.key_frame.valid()) {
    if (first) state_ = beginning_ ? TrackState::lost : TrackState::not_initialised;
    return;
  }
  const auto map = map_.read();
  if (first) {  // nothing to refresh, all to take over
    beginning_ = false;
    lost_since_.reset();
    lost_frames_ = 0;
    set_reference(*map, report.key_frame);
    last_place_ = last_.T_cw = map->at(report.key_frame).T_cw;
    last_T_cr_ = SE3();
    map_changed_ = false;
  }
  new_reference_ = report.key_frame;
  if (last_.index == report.frame) take_over_points(*map, report.key_frame);
  if (local_map_.reference.id != reference_ || local_map_.size() == 0) {
    local_map_.update(*map, {}, report.key_frame, options_.tracker.local_map.local_key_frames);
  }
}

// The last frame became this key frame: what mapping added to it is known of the frame too.
void Tracker::take_over_points(const Map& map, KeyFrameId key_frame) {
  const KeyFrame* source = map.find(key_frame);
  if (!source) return;
  for (size_t i = 0; i < source->points.size(); ++i) {
    const MapPointId id = source->points[i];
    last_.known[i] = id.valid() ? kMapPoint : kNone;
    last_.points[i] = id;
    if (id.valid()) last_.positions[i] = map.at(id).position_w;
  }
}

void Tracker::refresh_last_frame(const Map& map) {
  moves_ = map.moves();
  refresh_camera(map);
  if (const auto resolved = map.resolve(reference_)) {
    // After a loop lengths may have changed round here, of the camera's motion too.
    last_T_cr_ = resolved->carry(last_T_cr_, reference_scale_);
    velocity_ = SE3(velocity_.R(), Eigen::Vector3d(resolved->scale / reference_scale_ * velocity_.t()));
    set_reference(map, resolved->key_frame);
    last_.T_cw = (last_T_cr_ * map.at(reference_).T_cw).normalized();
    if (last_place_) last_place_ = last_.T_cw;
  }
  // Not when the camera was meanwhile found in another submap.
  if (const KeyFrame* made = map.find(new_reference_); made && made->submap == submap_) {
    set_reference(map, new_reference_);
    last_T_cr_ = last_.T_cw * map.at(reference_).T_cw.inverse();
  }
  new_reference_ = {};
  for (size_t i = 0; i < last_.points.size(); ++i) {
    if (last_.known[i] != kMapPoint) continue;
    last_.points[i] = map.forwarded(last_.points[i]);
    if (const MapPoint* point = map.find(last_.points[i])) {
      last_.positions[i] = point->position_w;
    } else {
      last_.known[i] = kNone;
      last_.points[i] = {};
    }
  }
  if (map.find(reference_)) local_map_.reference.copy(map, reference_);
}

void Tracker::set_reference(const Map& map, KeyFrameId key_frame) {
  reference_ = key_frame;
  reference_scale_ = map.at(key_frame).scale;
  submap_ = map.at(key_frame).submap;
}

int Tracker::optimize() {
  observations_.clear();
  observed_feature_.clear();
  const Features& f = *current_.features;
  for (size_t i = 0; i < current_.known.size(); ++i) {
    if (!current_.known[i]) continue;
    observations_.add(current_.positions[i], f.x[i], f.y[i], f.u_right[i], f.pyramid->inv_sigma2[f.level[i]]);
    observed_feature_.push_back(static_cast<int32_t>(i));
  }
  reserve_ahead(inlier_, observed_feature_.size());
  const PoseResult pose = optimize_pose(current_.T_cw, observations_, camera_, {}, inlier_);
  if (!pose.ok) return 0;
  current_.T_cw = pose.T_cw;
  information_ = pose.information;
  int on_map = 0;
  for (size_t k = 0; k < observed_feature_.size(); ++k) {
    const auto i = static_cast<size_t>(observed_feature_[k]);
    if (!inlier_[k]) {
      current_.known[i] = kNone;
      current_.points[i] = {};
    } else if (current_.known[i] == kMapPoint) {
      ++on_map;
    }
  }
  return on_map;
}

double Tracker::mean_depth() const {
  double sum = 0;
  int points = 0;
  for (size_t i = 0; i < current_.known.size(); ++i) {
    if (current_.known[i] != kMapPoint) continue;
    sum += (current_.T_cw * current_.positions[i]).z();
    ++points;
  }
  return points > 0 ? sum / points : 0;
}

void Tracker::count_points() {
  const auto slot_count = [&](MapPointId id) -> PointCount& {
    if (id.slot >= counts_.size()) counts_.resize(id.slot + id.slot / 2 + 256);
    PointCount& count = counts_[id.slot];
    if (count.point != id) {
      count = {id, 0, 0};
      counted_.push_back(id.slot);
    }
    return count;
  };
  for (size_t k = 0; k < local_map_.points.id.size(); ++k) {
    if (projection_.in_view()[k]) ++slot_count(local_map_.points.id[k]).visible;
  }
  for (size_t i = 0; i < current_.known.size(); ++i) {
    if (current_.known[i] == kMapPoint) ++slot_count(current_.points[i]).found;
  }
}

void Tracker::clear_counts() {
  for (const uint32_t slot : counted_) counts_[slot] = {};
  counted_.clear();
}

bool Tracker::turned_away() const {
  const ImageBounds& image = current_.features->grid.bounds;
  const double wider = std::max((image.max_x - image.min_x) / camera_.fx, (image.max_y - image.min_y) / camera_.fy);
  const double view = 2 * std::atan(wider / 2);  // angle
  const double turn = std::min(options_.tracker.key_frame.key_frame_turn * view, std::numbers::pi);
  const auto axis = [](const SE3& T_cw) { return T_cw.R().row(2); };
  return axis(current_.T_cw).dot(axis(local_map_.reference.T_cw)) < std::cos(turn);
}

bool Tracker::key_frame_due(const TrackResult& result, bool mapping_idle) const {
  const TrackerOptions& o = options_.tracker;
  if (options_.localize || result.inliers < o.key_frame.key_frame_min_inliers) return false;
  if (jumped_at_ || (lately(last_recovery_) && result.method != TrackMethod::motion_model)) return false;
  bool few_close = false;
  if (!monocular()) {
    const double close = close_depth();
    int tracked = 0, untracked = 0;
    for (size_t i = 0; i < current_.known.size(); ++i) {
      const float depth = current_.features->depth[i];
      if (!(depth > 0) || depth > close) continue;
      ++(current_.known[i] == kMapPoint ? tracked : untracked);
    }
    few_close = tracked < o.key_frame.min_close_points && untracked > o.key_frame.new_close_points;
  }
  const bool waited = current_.stamp - last_key_frame_stamp_ > from_seconds(o.key_frame.key_frame_interval);
  if (!mapping_idle && !(options_.realtime && (waited || few_close))) return false;
  if (monocular()) {
    // Many new points, of two views, let the camera go far before fewer are left than the older ones were.
    return result.inliers < o.key_frame.key_frame_ratio_mono * local_map_.reference_points ||
           result.inliers < o.key_frame.key_frame_all_ratio_mono * local_map_.reference_all_points;
  }
  return few_close || turned_away() || result.inliers < o.key_frame.key_frame_ratio * local_map_.reference_points;
}

// Features with depth up to the close bound, or the min_close_points nearest (ties: lower index) when those are fewer.
// In no particular order.
const std::vector<uint32_t>& Tracker::near_features(const TrackedFrame& frame) {
  const Features& f = *frame.features;
  const double close = close_depth();
  near_.clear();
  size_t close_count = 0;
  for (uint32_t i = 0; i < static_cast<uint32_t>(f.size()); ++i) {
    if (!(f.depth[i] > 0)) continue;
    near_.push_back(i);
    close_count += f.depth[i] <= close;
  }
  const auto wanted = std::max(close_count, static_cast<size_t>(options_.tracker.key_frame.min_close_points));
  if (wanted < near_.size()) {
    std::nth_element(near_.begin(), near_.begin() + static_cast<ptrdiff_t>(wanted), near_.end(), NearerFeature{f});
    near_.resize(wanted);
  }
  return near_;
}

KeyFrameRequest Tracker::make_key_frame_request() {
  KeyFrameRequest request;
  request.frame = current_.index;
  request.stamp = current_.stamp;
  request.features = current_.features;
  request.pose = {reference_, reference_scale_, last_T_cr_};
  request.points.assign(current_.points.size(), {});
  for (size_t i = 0; i < current_.points.size(); ++i) {
    if (current_.known[i] == kMapPoint) request.points[i] = current_.points[i];
  }
  if (!monocular()) {
    for (const uint32_t i : near_features(current_)) {
      if (current_.known[i] != kMapPoint) request.new_points.push_back(i);
    }
    std::sort(request.new_points.begin(), request.new_points.end(), NearerFeature{*current_.features});
  }
  for (const uint32_t slot : counted_) request.counts.push_back(counts_[slot]);
  clear_counts();
  last_key_frame_stamp_ = current_.stamp;
  return request;
}

}  // namespace covis
