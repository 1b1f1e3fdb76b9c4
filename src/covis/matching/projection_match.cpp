// SPDX-License-Identifier: Apache-2.0
#include "covis/matching/projection_match.h"

#include "covis/core/reserve.h"
#include "covis/geometry/measurement.h"

namespace covis {
namespace {

// A point's measurement at a pose; none behind the camera or outside the image.
struct Projected {
  float u = 0, v = 0;   // pixels, undistorted
  float disparity = 0;  // pixels; 0: the camera has no depth sensor
};

std::optional<Projected> project(const Eigen::Vector3d& position_w, const SE3& T_cw, const Pinhole& camera,
                                 const Features& features) {
  const Eigen::Vector3d p_c = T_cw * position_w;
  if (!(p_c.z() > 0)) return std::nullopt;
  const PredictedMeasurement h = predict_measurement(p_c, camera);
  const Projected at{static_cast<float>(h.u), static_cast<float>(h.v), static_cast<float>(h.disparity)};
  if (!features.grid.bounds.contains(at.u, at.v)) return std::nullopt;
  return at;
}

}  // namespace

std::optional<PredictedView> predict_view(const ViewablePoint& point, const SE3& T_cw, const Eigen::Vector3d& centre_w,
                                          const Pinhole& camera, const Features& features) {
  constexpr float kNearestShare = 0.8f, kFarthestShare = 1.2f;  // shares of the range of distances
  constexpr float kMinCosine = 0.5f;                            // 60 degrees
  const auto at = project(point.position_w, T_cw, camera, features);
  if (!at) return std::nullopt;
  const Eigen::Vector3f ray = (point.position_w - centre_w).cast<float>();
  const float distance = ray.norm();
  const float apparent = distance * features.pyramid->base;  // to a camera whose pixels are those of level 0
  if (apparent < kNearestShare * point.d_min || apparent > kFarthestShare * point.d_max) return std::nullopt;
  const float cosine = ray.dot(point.normal_w) / distance;
  if (cosine < kMinCosine) return std::nullopt;
  return PredictedView{at->u, at->v, at->disparity, cosine, features.pyramid->predict_level(point.d_max, distance)};
}

// Reserves room in advance; its memory is used only when points come.
ProjectionMatcher::ProjectionMatcher() {
  constexpr size_t kPoints = 1 << 14, kFeatures = 1 << 12;
  queries_.reserve(kPoints);
  source_.reserve(kPoints);
  found_.reserve(kPoints);
  in_view_.reserve(kPoints);
  unlike_.reserve(kPoints);
  matches_.reserve(kFeatures);
  angle_then_.reserve(kFeatures);
  angle_now_.reserve(kFeatures);
}

std::optional<WindowQuery> ProjectionMatcher::query(const PointSet& points, size_t k, const Frame& frame,
                                                    const Eigen::Vector3d& centre_w, const MatchGate& gate) const {
  constexpr float kFrontal = 0.998f;  // cosine of 3.6 degrees
  const auto view = predict_view(points.viewable(k), frame.T_cw, centre_w, frame.camera, frame.features);
  if (!view) return std::nullopt;
  const auto window = static_cast<float>(view->cosine > kFrontal ? gate.window_frontal : gate.window);
  return WindowQuery{view->u,
                     view->v,
                     view->disparity,
                     window * frame.features.pyramid->scale[static_cast<size_t>(view->level)],
                     view->level - 1,
                     view->level,
                     &points.descriptor[k]};
}

std::optional<WindowQuery> ProjectionMatcher::query_seen(const PointSet& points, size_t k, const Frame& frame,
                                                         const MatchGate& gate) const {
  const auto at = project(points.position(k), frame.T_cw, frame.camera, frame.features);
  if (!at) return std::nullopt;
  const auto [u, v, disparity] = *at;
  const int level = points.level[k], top = frame.features.pyramid->levels - 1;
  const float radius = static_cast<float>(gate.window) * frame.features.pyramid->scale[points.level[k]];
  switch (gate.levels) {
    case LevelRule::seen_or_larger:
      return WindowQuery{u, v, disparity, radius, level, top, &points.descriptor[k]};
    case LevelRule::seen_or_finer:
      return WindowQuery{u, v, disparity, radius, 0, level, &points.descriptor[k]};
    default:
      return WindowQuery{u, v, disparity, radius, level - 1, level + 1, &points.descriptor[k]};
  }
}

int ProjectionMatcher::match(const PointSet& points, const Frame& frame, const MatchGate& gate,
                             std::span<const uint8_t> known, std::span<const uint8_t> taken) {
  const Eigen::Vector3d centre_w = frame.T_cw.centre();
  const size_t n = points.size();
  queries_.clear();
  source_.clear();
  reserve_ahead(in_view_, n);
  in_view_.assign(n, 0);
  int in_view = 0;
  for (size_t k = 0; k < n; ++k) {
    if (!known.empty() && known[k]) {
      in_view_[k] = 1;
      ++in_view;
      continue;
    }
    const auto query_k = gate.levels == LevelRule::predicted ? query(points, k, frame, centre_w, gate)
                                                             : query_seen(points, k, frame, gate);
    if (!query_k) continue;
    in_view_[k] = 1;
    ++in_view;
    queries_.push_back(*query_k);
    source_.push_back(static_cast<uint32_t>(k));
  }
  const WindowMatchOptions options{
      .max_distance = gate.max_distance, .ratio = gate.ratio, .within_bound = gate.error == MatchError::within_bound};
  windows_.match(frame.features, queries_, taken, frame.camera, options, found_);
  matches_.clear();
  unlike_.clear();
  for (size_t q = 0; q < found_.size(); ++q) {
    if (found_[q] >= 0) matches_.push_back({static_cast<uint32_t>(found_[q]), source_[q]});
    if (found_[q] == WindowMatcher::kUnlike) unlike_.push_back(source_[q]);
  }
  return in_view;
}

int ProjectionMatcher::keep_consistent_rotations(std::span<const float> angle, const Features& features) {
  angle_then_.clear();
  angle_now_.clear();
  for (const PointMatch& m : matches_) {
    angle_then_.push_back(angle[m.point]);
    angle_now_.push_back(features.angle[m.feature]);
  }
  reserve_ahead(keep_, matches_.size());
  keep_.assign(matches_.size(), 1);
  const int kept = check_rotation(angle_then_, angle_now_, keep_);
  size_t next = 0;
  for (size_t k = 0; k < keep_.size(); ++k) {
    if (keep_[k]) matches_[next++] = matches_[k];
  }
  matches_.resize(next);
  return kept;
}

}  // namespace covis
