// SPDX-License-Identifier: Apache-2.0
#include "covis/tracking/first_pose.h"

#include "covis/core/random.h"

namespace covis {
namespace {

// Share of the last frame's points in view that must agree with a pose for no other to be looked for.
constexpr double kExplains = 0.2;
// A later hypothesis has to have so many times the points that agree: the prediction is the better start otherwise.
constexpr double kBetter = 1.5;

}  // namespace

FirstPose::Hypothesis FirstPose::around(const TrackedFrame& last, TrackedFrame& frame, PoseSearch& search) const {
  const double window = options_.window(sensor_);
  Hypothesis h;
  FrameMatcher::LastFrameMatches found = search.matcher.match_last_frame(last, frame, search.camera, window);
  if (found.matches < options_.motion_min_matches)
    found = search.matcher.match_last_frame(last, frame, search.camera, 2 * window);
  h.matches = found.matches;
  if (h.matches < options_.motion_min_matches) {
    h.reason = "too few matches with the last frame";
    return h;
  }
  const int on_map = search.matcher.fit_pose(frame, search.camera).on_map;
  h.inliers = frame.matches();
  h.share = found.in_view > 0 ? static_cast<double>(h.inliers) / found.in_view : 0;
  if ((support_ == Support::all_points ? h.inliers : on_map) < options_.motion_min_inliers)
    h.reason = "too few matches with the last frame agree on a pose";
  return h;
}

FirstPose::Hypothesis FirstPose::by_motion(const TrackedFrame& last, const SE3& T_cl, TrackedFrame& frame,
                                           PoseSearch& search) const {
  frame.T_cw = (T_cl * last.T_cw).normalized();
  Hypothesis h = around(last, frame, search);
  h.method = TrackMethod::motion_model;
  return h;
}

FirstPose::Hypothesis FirstPose::by_descriptors(const TrackedFrame& last, TrackedFrame& frame,
                                                PoseSearch& search) const {
  // Wide gates, as RANSAC sorts out what is wrong.
  constexpr DescriptorMatchOptions kGate{.max_distance = 64, .ratio = 0.9f};
  Hypothesis h;
  h.matches = FrameMatcher::match_frame(last, frame, kGate);
  if (h.matches < options_.reference_min_matches) {
    h.reason = "too few matches with the last frame";
  } else if (!search.matcher.find_pose(frame, search.camera, seed_)) {
    h.reason = "too few matches with the last frame agree on a pose";
  } else {
    h = around(last, frame, search);
  }
  h.method = TrackMethod::last_frame;
  return h;
}

FirstPose::Hypothesis FirstPose::by_reference(const TrackedFrame& last, TrackedFrame& frame,
                                              PoseSearch& search) const {
  const KeyFrameView& reference = search.local_map.reference;
  Hypothesis h;
  h.method = TrackMethod::reference_key_frame;
  if (!reference.features) {
    h.reason = "no reference key frame";
    return h;
  }
  const DescriptorMatchOptions gate{.max_distance = kHammingLow, .ratio = static_cast<float>(options_.reference_ratio)};
  h.matches = FrameMatcher::match_key_frame(reference, frame, gate);
  frame.T_cw = last.T_cw;
  if (h.matches < options_.reference_min_matches) {
    h.reason = "too few matches with the reference key frame";
    return h;
  }
  h.inliers = search.matcher.fit_pose(frame, search.camera).on_map;
  if (h.inliers < options_.motion_min_inliers) h.reason = "too few matches with the reference key frame agree on a pose";
  return h;
}

bool FirstPose::find(const TrackedFrame& last, const std::optional<SE3>& T_cl, TrackedFrame& frame, PoseSearch& search,
                     TrackResult& figures) {
  Hypothesis best;
  const auto try_next = [&](const Hypothesis& h) {
    if (h.ok() && (!best.ok() || h.inliers > kBetter * best.inliers)) {
      best = h;
    } else if (best.ok()) {
      std::swap(frame, best_);
    } else if (best.method == TrackMethod::none) {
      best = h;
    }
  };
  if (T_cl) best = by_motion(last, *T_cl, frame, search);
  if (!T_cl) best = by_reference(last, frame, search);
  if (T_cl ? !(best.ok() && best.share >= kExplains) : !best.ok()) {
    if (best.ok()) best_ = frame;
    try_next(by_descriptors(last, frame, search));
  }
  if (T_cl && !best.ok()) try_next(by_reference(last, frame, search));
  figures.predicted_matches = best.matches;
  figures.first_share = best.share;
  figures.reason = best.reason;
  if (best.ok()) figures.method = best.method;
  return best.ok();
}

}  // namespace covis
