// SPDX-License-Identifier: Apache-2.0
#include "covis/tracking/key_frame_policy.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "covis/tracking/near_features.h"

namespace covis {

const std::vector<uint32_t>& KeyFramePolicy::near_features(const Features& features, const Pinhole& camera) {
  select_near_features(features, close_depth(camera), options_.min_close_points, near_);
  return near_;
}

bool KeyFramePolicy::few_close_points(const TrackedFrame& frame, const Pinhole& camera) const {
  const double close = close_depth(camera);
  int tracked = 0, untracked = 0;
  for (size_t i = 0; i < frame.source.size(); ++i) {
    const float depth = frame.features->depth[i];
    if (!(depth > 0) || depth > close || frame.moves(i)) continue;
    ++(frame.on_map(i) ? tracked : untracked);
  }
  return tracked < options_.min_close_points && untracked > options_.new_close_points;
}

// True when the translation from the reference key frame would move the tracked points by so much, were it across the
// view. The share of points that is left says little of that where most are far: they stay in view, while the near
// ones, which alone tell the translation, are lost before they were seen often enough to hold the scale.
bool KeyFramePolicy::moved_away(const TrackedFrame& frame, const KeyFrameView& reference) const {
  double inverse_squares = 0;
  int points = 0;
  for (size_t i = 0; i < frame.source.size(); ++i) {
    if (!frame.on_map(i)) continue;
    const double depth = (frame.T_cw * frame.positions[i]).z();
    if (!(depth > 0)) continue;
    inverse_squares += 1 / (depth * depth);
    ++points;
  }
  const double bound = options_.key_frame_parallax_mono;
  const double squared_baseline = (frame.T_cw.centre() - reference.T_cw.centre()).squaredNorm();
  return squared_baseline * inverse_squares > bound * bound * points;
}

// True when the view has turned so far from the reference key frame's that too few key frames would see the places in
// between.
bool KeyFramePolicy::turned_away(const TrackedFrame& frame, const KeyFrameView& reference,
                                 const Pinhole& camera) const {
  const ImageBounds& image = frame.features->grid.bounds;
  const double wider = std::max((image.max_x - image.min_x) / camera.fx, (image.max_y - image.min_y) / camera.fy);
  const double angle_of_view = 2 * std::atan(wider / 2);
  const double turn = std::min(options_.key_frame_turn * angle_of_view, std::numbers::pi);
  const auto axis = [](const SE3& T_cw) { return T_cw.R().row(2); };
  return axis(frame.T_cw).dot(axis(reference.T_cw)) < std::cos(turn);
}

bool KeyFramePolicy::is_due(const TrackedFrame& frame, int inliers, const LocalMap& local_map, const Pinhole& camera,
                            MappingLoad load) const {
  const KeyFrameOptions& o = options_;
  if (inliers < o.key_frame_min_inliers) return false;
  const bool monocular = sensor_ == Sensor::monocular;
  const bool few_close = !monocular && few_close_points(frame, camera);
  const bool waited = frame.stamp - last_stamp_ > from_seconds(o.key_frame_interval);
  if (load == MappingLoad::busy && !(schedule_ == Schedule::realtime && (waited || few_close))) return false;
  if (monocular) {
    // The share of all points counts too: many new points, of two views, would let the camera move far before fewer
    // matches are left than the reference has older points.
    return inliers < o.key_frame_ratio_mono * local_map.reference_points ||
           inliers < o.key_frame_all_ratio_mono * local_map.reference_all_points ||
           moved_away(frame, local_map.reference);
  }
  return few_close || turned_away(frame, local_map.reference, camera) ||
         inliers < o.key_frame_ratio * local_map.reference_points;
}

KeyFrameRequest KeyFramePolicy::request(const TrackedFrame& frame, const RelativePose& pose, const Pinhole& camera) {
  KeyFrameRequest request = frame.request();
  request.pose = pose;
  for (size_t i = 0; i < frame.points.size(); ++i) {
    if (frame.on_map(i)) request.points[i] = frame.points[i];
  }
  if (sensor_ != Sensor::monocular) {
    for (const uint32_t i : near_features(*frame.features, camera)) {
      if (!frame.on_map(i) && !frame.moves(i)) request.new_points.push_back(i);
    }
    std::sort(request.new_points.begin(), request.new_points.end(), NearerFeature{*frame.features});
  }
  request.counts = counts_.take();
  last_stamp_ = frame.stamp;
  return request;
}

}  // namespace covis
