// SPDX-License-Identifier: Apache-2.0
#include "covis/tracking/first_pose.h"

#include <numbers>
#include <utility>

#include "covis/geometry/se3.h"
#include "covis/tracking/motion_model.h"

namespace covis {
namespace {

// A later hypothesis has to have so many times the points that agree: the prediction is the better start otherwise.
constexpr double kBetter = 1.5;

}  // namespace

FirstPose::Hypothesis FirstPose::around(const TrackedFrame& last, TrackedFrame& frame, PoseSearch& search,
                                        const Pinhole& camera) {
  const double window = options_.window(sensor_);
  Hypothesis h;
  FrameMatcher::LastFrameMatches found = search.matcher.match_last_frame(last, frame, camera, window);
  if (found.matches < options_.motion_min_matches)
    found = search.matcher.match_last_frame(last, frame, camera, 2 * window);
  if (sensor_ != Sensor::monocular) h.depth = depth_.compare(frame, *frame.features, search.camera);
  h.matches = found.matches;
  if (h.matches < options_.motion_min_matches) {
    h.reason = NoPoseReason::few_matches_with_last_frame;
    return h;
  }
  const int on_map = search.matcher.fit_pose(frame, search.local_map, camera);
  h.inliers = frame.matches();
  h.share = found.in_view > 0 ? static_cast<double>(h.inliers) / found.in_view : 0;
  if ((support_ == Support::all_points ? h.inliers : on_map) < options_.motion_min_inliers)
    h.reason = NoPoseReason::few_agree_with_last_frame;
  return h;
}

FirstPose::Hypothesis FirstPose::by_motion(const TrackedFrame& last, const SE3& T_cl, TrackedFrame& frame,
                                           PoseSearch& search) {
  frame.T_cw = (T_cl * last.T_cw).normalized();
  Hypothesis h = around(last, frame, search, search.camera);
  h.method = TrackMethod::motion_model;
  return h;
}

// The search compares depths itself, so that what contradicts is hardly matched.
bool FirstPose::depth_is_suspicious(const TrackedFrame& last, const Hypothesis& found, const Pinhole& camera) {
  constexpr int kEnough = 30;
  constexpr double kFew = 0.4;
  if (sensor_ == Sensor::monocular) return false;
  if (found.depth.is_suspicious()) return true;
  const int before = DepthComparer::count(last, *last.features, camera);
  return before >= kEnough && found.depth.points < kFew * before;
}

FirstPose::Hypothesis FirstPose::by_image_alone(const TrackedFrame& last, const SE3& T_cl, const Hypothesis& found,
                                                TrackedFrame& frame, PoseSearch& search) {
  best_ = frame;
  frame.T_cw = (T_cl * last.T_cw).normalized();
  Hypothesis h = around(last, frame, search, search.camera.without_depth());
  if (h.explains() && depth_.compare(frame, *frame.features, search.camera).contradicts()) {
    frame.features = remover_.without_depth(*frame.features);
    h.method = TrackMethod::motion_model;
    return h;
  }
  std::swap(frame, best_);
  return found;
}

FirstPose::Hypothesis FirstPose::by_descriptors(const TrackedFrame& last, TrackedFrame& frame, PoseSearch& search) {
  Hypothesis h;
  h.matches = FrameMatcher::match_frame(last, frame, kForRansac);
  if (h.matches < options_.reference_min_matches) {
    h.reason = NoPoseReason::few_matches_with_last_frame;
  } else if (!search.matcher.find_pose(frame, search.camera, seed_)) {
    h.reason = NoPoseReason::few_agree_with_last_frame;
  } else {
    h = around(last, frame, search, search.camera);
  }
  h.method = TrackMethod::last_frame;
  return h;
}

FirstPose::Hypothesis FirstPose::by_reference(const TrackedFrame& last, TrackedFrame& frame, PoseSearch& search) const {
  const KeyFrameView& reference = search.local_map.reference;
  Hypothesis h;
  h.method = TrackMethod::reference_key_frame;
  if (!reference.features) {
    h.reason = NoPoseReason::no_reference_key_frame;
    return h;
  }
  const DescriptorMatchOptions gate{.max_distance = kHammingLow, .ratio = static_cast<float>(options_.reference_ratio)};
  h.matches = FrameMatcher::match_key_frame(reference, frame, gate);
  frame.T_cw = last.T_cw;
  if (h.matches < options_.reference_min_matches) {
    h.reason = NoPoseReason::few_matches_with_key_frame;
    return h;
  }
  h.inliers = search.matcher.fit_pose(frame, search.local_map, search.camera);
  if (h.inliers < options_.motion_min_inliers) h.reason = NoPoseReason::few_agree_with_key_frame;
  return h;
}

FirstPose::Hypothesis FirstPose::by_images(const TrackedFrame& last, const SE3& T_cl, TrackedFrame& frame,
                                           PoseSearch& search) {
  turn_seen_ = image_rotation(last.features->small, frame.features->small, search.camera);
  if (!turn_seen_) return {.method = TrackMethod::image_rotation, .reason = NoPoseReason::no_rotation_seen};
  Hypothesis h = by_motion(last, MotionModel::turned(T_cl, *turn_seen_), frame, search);
  h.method = TrackMethod::image_rotation;
  return h;
}

bool FirstPose::find(const TrackedFrame& last, const std::optional<SE3>& T_cl, TrackedFrame& frame, PoseSearch& search,
                     TrackResult& figures) {
  turn_seen_.reset();
  Hypothesis best;
  // Keeps the better one of two hypotheses, and the frame as that has it.
  const auto compete = [&](auto&& hypothesis) {
    if (best.ok()) best_ = frame;
    const Hypothesis h = hypothesis();
    if (h.ok() && (!best.ok() || h.inliers > kBetter * best.inliers)) {
      best = h;
    } else if (best.ok()) {
      std::swap(frame, best_);
    }
  };
  if (T_cl) {
    best = by_motion(last, *T_cl, frame, search);
    if (depth_is_suspicious(last, best, search.camera)) best = by_image_alone(last, *T_cl, best, frame, search);
    if (!best.explains()) {
      compete([&] { return by_images(last, *T_cl, frame, search); });
      if (!best.explains()) compete([&] { return by_descriptors(last, frame, search); });
      if (!best.ok()) compete([&] { return by_reference(last, frame, search); });
    }
  } else {
    best = by_reference(last, frame, search);
    if (!best.ok()) compete([&] { return by_descriptors(last, frame, search); });
  }
  best_.features.reset();  // the ring of features wants them back
  figures.predicted_matches = best.matches;
  figures.first_share = best.share;
  figures.reason = best.reason;
  if (best.ok()) figures.method = best.method;
  return best.ok();
}

bool FirstPose::images_agree(const SE3& T_cl) const {
  constexpr double kAgree = 1.5 / 180 * std::numbers::pi;
  return turn_seen_ && so3_log(*turn_seen_ * T_cl.R().transpose()).norm() < kAgree;
}

}  // namespace covis
