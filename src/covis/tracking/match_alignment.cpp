// SPDX-License-Identifier: Apache-2.0
#include "covis/tracking/match_alignment.h"

#include <algorithm>
#include <optional>

#include "covis/core/reserve.h"
#include "covis/matching/point_geometry.h"

namespace covis {

// Copies what the map knows, so that no guard is held while matches are aligned.
void MatchAlignment::ask(const Map& map, const TrackedFrame& frame) {
  questions_.clear();
  reserve_ahead(questions_, frame.source.size());
  KeyFrameId last;  // the reference of the last match
  SE3 T_vr;
  for (size_t i = 0; i < frame.source.size(); ++i) {
    if (!frame.on_map(i)) continue;
    const MapPoint* point = map.find(frame.points[i]);
    if (!point) continue;
    const KeyFrame& reference = map.at(point->reference);
    if (point->reference != last) T_vr = frame.T_cw * reference.T_cw.inverse();
    last = point->reference;
    const auto question = PatchQuestion::of(map.camera(), *reference.features, point->feature_in(last),
                                            reference.T_cw * point->position_w, T_vr, *frame.features, i);
    if (question) questions_.push_back({static_cast<uint32_t>(i), *question});
  }
}

void MatchAlignment::observe(const Pinhole& camera, const TrackedFrame& frame) {
  const Features& f = *frame.features;
  const float closer = aligned_weight(camera);
  observations_.clear();
  if (const size_t n = frame.source.size(); observations_.u.capacity() < n) observations_.reserve(n + n / 2);
  auto next = questions_.begin();
  for (size_t i = 0; i < frame.source.size(); ++i) {
    if (frame.source[i] == PointSource::none) continue;
    std::optional<AlignedPlace> place;
    if (next != questions_.end() && next->feature == i) place = next++->of_point.answer(f, i);
    const float weight = f.pyramid->inv_sigma2[f.level[i]];
    const Eigen::Vector2f at = place ? place->undistorted : Eigen::Vector2f(f.x[i], f.y[i]);
    observations_.add(frame.positions[i], at.x(), at.y(), place ? closer * weight : weight, disparity_of(f, i, camera));
  }
}

std::optional<int> MatchAlignment::refine_pose(const SharedMap& map, const Pinhole& camera, int least,
                                               std::optional<uint64_t> moves, TrackedFrame& frame) {
  if (!frame.features->patches) return std::nullopt;
  {
    const auto now = map.read();
    if (moves && now->moves() != *moves) return std::nullopt;
    ask(*now, frame);
  }
  if (questions_.empty()) return std::nullopt;
  observe(camera, frame);
  reserve_ahead(inlier_, static_cast<size_t>(observations_.size()));
  const PoseResult pose = optimize_pose(frame.T_cw, observations_, camera, {.rounds = 2}, inlier_);
  if (!pose.ok || 2 * pose.inliers < observations_.size()) return std::nullopt;
  int on_map = 0;
  auto fits = inlier_.begin();
  for (size_t i = 0; i < frame.source.size(); ++i)
    if (frame.source[i] != PointSource::none) on_map += *fits++ && frame.on_map(i);
  if (on_map < least) return std::nullopt;
  frame.T_cw = pose.T_cw;
  frame.information = pose.information;
  fits = inlier_.begin();
  for (size_t i = 0; i < frame.source.size(); ++i)
    if (frame.source[i] != PointSource::none && !*fits++) frame.drop_match(i);
  return on_map;
}

}  // namespace covis
