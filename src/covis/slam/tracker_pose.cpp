// SPDX-License-Identifier: Apache-2.0
// The steps that find a frame's pose: motion model, reference key frame, local map (ORB-SLAM, V-B and V-D).
#include <algorithm>

#include "covis/core/reserve.h"
#include "covis/core/time.h"
#include "covis/matching/descriptor_match.h"
#include "covis/matching/point_geometry.h"
#include "covis/slam/tracker.h"

namespace covis {

// Points of the last frame's own depth, for one frame only: the map may have few yet.
void Tracker::add_temporary_points() {
  if (monocular()) return;
  const SE3 T_wl = last_.T_cw.inverse();
  for (const uint32_t i : near_features(last_)) {
    if (last_.known[i] == kMapPoint) continue;
    last_.known[i] = kTemporary;
    last_.positions[i] = T_wl * unproject_depth(camera_, *last_.features, i);
  }
}

// As fast as before. Frames may have been left out, by whoever calls or as they came late; a small difference of times
// is jitter of the stamps. After a longer pause nothing is expected.
std::optional<SE3> Tracker::expected_motion() const {
  constexpr double kJitter = 1.4, kPause = 5;
  if (!has_velocity_) return std::nullopt;
  const double times = static_cast<double>(current_.stamp - last_.stamp) / static_cast<double>(velocity_time_);
  if (times > kPause) return std::nullopt;
  return times < kJitter && times > 1 / kJitter ? velocity_ : SE3::exp(times * velocity_.log());
}

bool Tracker::track_by_motion(TrackResult& result) {
  const std::optional<SE3> motion = expected_motion();
  if (!motion) return false;
  const Stopwatch watch;
  const TrackerOptions& o = options_.tracker;
  add_temporary_points();
  current_.T_cw = (*motion * last_.T_cw).normalized();
  const double window = options_.sensor == Sensor::stereo ? o.first_pose.motion_window_stereo : o.first_pose.motion_window;
  int matches = search_last_frame(window);
  if (matches < o.first_pose.motion_min_matches) matches = search_last_frame(2 * window);
  result.predicted_matches = matches;
  bool ok = matches >= o.first_pose.motion_min_matches;
  if (!ok) {
    result.reason = "too few matches with the last frame";
  } else if (const int on_map = optimize(); (may_bridge() ? all_inliers() : on_map) < o.first_pose.motion_min_inliers) {
    result.reason = "too few matches with the last frame agree on a pose";
    ok = false;
  }
  if (ok) result.method = TrackMethod::motion_model;
  result.motion_ms += watch.ms();
  return ok;
}

int Tracker::search_last_frame(double window) {
  const Features& from = *last_.features;
  const Features& to = *current_.features;
  // Moving along the optical axis by more than the baseline, a point can only be found at levels finer or coarser than
  // before.
  const double forward = (last_.T_cw * current_.T_cw.centre()).z();
  const bool ahead = !monocular() && forward > camera_.baseline();
  const bool back = !monocular() && -forward > camera_.baseline();
  const int top = to.pyramid->levels - 1;
  queries_.clear();
  query_source_.clear();
  for (size_t i = 0; i < last_.known.size(); ++i) {
    if (!last_.known[i]) continue;
    const Eigen::Vector3d p_c = current_.T_cw * last_.positions[i];
    if (!(p_c.z() > 0)) continue;
    const Eigen::Vector2f pixel = camera_.project(p_c).cast<float>();
    if (!to.grid.bounds.contains(pixel.x(), pixel.y())) continue;
    const int level = from.level[i];
    const float u_right = camera_.bf > 0 ? static_cast<float>(pixel.x() - camera_.bf / p_c.z()) : -1.0f;
    queries_.push_back({pixel.x(), pixel.y(), u_right,
                        static_cast<float>(window) * to.pyramid->scale[static_cast<size_t>(level)],
                        ahead  ? level
                        : back ? 0
                               : level - 1,
                        ahead  ? top
                        : back ? level
                               : level + 1,
                        &from.descriptor[i]});
    query_source_.push_back(static_cast<int32_t>(i));
  }
  matcher_.match(to, queries_, {}, {.max_distance = kHammingHigh}, match_);

  angle_a_.clear();
  angle_b_.clear();
  matched_query_.clear();
  for (size_t q = 0; q < match_.size(); ++q) {
    if (match_[q] < 0) continue;
    angle_a_.push_back(from.angle[static_cast<size_t>(query_source_[q])]);
    angle_b_.push_back(to.angle[static_cast<size_t>(match_[q])]);
    matched_query_.push_back(static_cast<int32_t>(q));
  }
  reserve_ahead(keep_, matched_query_.size());
  keep_.assign(matched_query_.size(), 1);
  const int kept = check_rotation(angle_a_, angle_b_, keep_);
  std::fill(current_.known.begin(), current_.known.end(), kNone);
  std::fill(current_.points.begin(), current_.points.end(), MapPointId{});
  for (size_t k = 0; k < keep_.size(); ++k) {
    if (!keep_[k]) continue;
    const auto q = static_cast<size_t>(matched_query_[k]);
    const auto source = static_cast<size_t>(query_source_[q]);
    set_match(static_cast<size_t>(match_[q]), last_.points[source], last_.positions[source], last_.known[source]);
  }
  return kept;
}

void Tracker::set_match(size_t feature, MapPointId point, const Eigen::Vector3d& position_w, uint8_t known) {
  current_.points[feature] = point;
  current_.positions[feature] = position_w;
  current_.known[feature] = known;
}

int Tracker::match_key_frame(const KeyFrameView& view, double ratio, int max_distance) {
  std::vector<uint8_t> use(view.points.size());
  for (size_t i = 0; i < use.size(); ++i) use[i] = view.points[i].valid();
  const auto matches = match_descriptors(*current_.features, {}, *view.features, use,
                                         {.max_distance = max_distance, .ratio = static_cast<float>(ratio)});
  std::fill(current_.known.begin(), current_.known.end(), kNone);
  std::fill(current_.points.begin(), current_.points.end(), MapPointId{});
  for (const FeatureMatch& m : matches) {
    const auto b = static_cast<size_t>(m.b);
    set_match(static_cast<size_t>(m.a), view.points[b], view.positions[b], kMapPoint);
  }
  return static_cast<int>(matches.size());
}

bool Tracker::track_by_reference(TrackResult& result) {
  const Stopwatch watch;
  const TrackerOptions& o = options_.tracker;
  bool ok = false;
  if (!local_map_.reference.features) {
    result.reason = "no reference key frame";
  } else {
    result.predicted_matches = match_key_frame(local_map_.reference, o.first_pose.reference_ratio, kHammingLow);
    current_.T_cw = last_.T_cw;
    if (result.predicted_matches < o.first_pose.reference_min_matches) {
      result.reason = "too few matches with the reference key frame";
    } else if (optimize() < o.first_pose.motion_min_inliers) {
      result.reason = "too few matches with the reference key frame agree on a pose";
    } else {
      ok = true;
      result.method = TrackMethod::reference_key_frame;
    }
  }
  result.motion_ms += watch.ms();
  return ok;
}

bool Tracker::track_local_map(TrackResult& result, bool map_is_live) {
  const TrackerOptions& o = options_.tracker;
  Stopwatch watch;
  if (map_is_live) update_local_map(reference_);
  result.local_update_ms += watch.ms();
  watch.restart();
  const bool recovered_lately = lately(last_recovery_);
  const double factor = recovered_lately ? 5.0 : options_.sensor == Sensor::rgbd ? o.local_map.local_window_rgbd : 1.0;
  result.local_in_view = search_local_map(factor);
  result.local_points = local_map_.size();
  result.local_search_ms += watch.ms();
  watch.restart();
  result.inliers = optimize();
  result.pose_ms += watch.ms();
  if (result.inliers < (recovered_lately ? o.recovery.min_inliers_recovered : o.local_map.min_inliers)) {
    result.reason = "too few points of the map agree on a pose";
    return false;
  }
  const bool elsewhere_lately = recovered_lately || jumped_at_;
  if (elsewhere_lately && !well_determined()) {
    result.reason = "points of the map agree on a pose, but leave it uncertain";
    return false;
  }
  const bool may_be_elsewhere = elsewhere_lately || result.method == TrackMethod::reference_key_frame;
  if (may_be_elsewhere && !is_right_place(map_is_live, false)) {
    result.reason = "things match, but not what stands round them";
    return false;
  }
  return true;
}

void Tracker::update_local_map(KeyFrameId fallback) {
  matched_.clear();
  for (size_t i = 0; i < current_.known.size(); ++i) {
    if (current_.known[i] == kMapPoint) matched_.push_back(current_.points[i]);
  }
  local_map_.update(*map_.read(), matched_, fallback, options_.tracker.local_map.local_key_frames);
}

void Tracker::mark_matched() {
  ++matched_epoch_;
  for (size_t i = 0; i < current_.known.size(); ++i) {
    if (current_.known[i] != kMapPoint) continue;
    const uint32_t slot = current_.points[i].slot;
    if (slot >= matched_mark_.size()) matched_mark_.resize(slot + slot / 2 + 256);
    matched_mark_[slot] = matched_epoch_;
  }
}

int Tracker::search_local_map(double window_factor) {
  const TrackerOptions& o = options_.tracker;
  mark_matched();
  reserve_ahead(taken_, current_.known.size());
  taken_.assign(current_.known.size(), 0);
  for (size_t i = 0; i < current_.known.size(); ++i) taken_[i] = current_.known[i] == kMapPoint;
  const size_t n = local_map_.points.size();
  reserve_ahead(known_, n);
  known_.resize(n);
  for (size_t k = 0; k < n; ++k) known_[k] = matched(local_map_.points.id[k]);
  const MatchGate gate =
      MatchGate::local_map(o.local_map.local_window * window_factor, o.local_map.local_window_frontal * window_factor, o.local_map.local_ratio);
  const int in_view =
      projection_.match(local_map_.points, {camera_, *current_.features, current_.T_cw}, gate, known_, taken_);
  for (const PointMatch& m : projection_.matches()) {
    set_match(m.feature, local_map_.points.id[m.point], local_map_.points.position(m.point), kMapPoint);
  }
  return in_view;
}

}  // namespace covis
