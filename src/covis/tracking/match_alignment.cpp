// SPDX-License-Identifier: Apache-2.0
#include "covis/tracking/match_alignment.h"

#include <optional>

#include "covis/matching/point_geometry.h"

namespace covis {

// Reserves room in advance; its memory is used only when matches come.
MatchAlignment::MatchAlignment() {
  constexpr size_t kFeatures = 1 << 12;
  questions_.reserve(kFeatures);
  observations_.reserve(kFeatures);
  inlier_.reserve(kFeatures);
}

// Copies what the map knows, so that no guard is held while matches are aligned.
void MatchAlignment::ask(const Map& map, const TrackedFrame& frame) {
  questions_.clear();
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

void MatchAlignment::refine_pose(const SharedMap& map, const Pinhole& camera, std::optional<uint64_t> moves,
                                 TrackedFrame& frame) {
  if (!frame.features->patches) return;
  {
    const auto now = map.read();
    if (moves && now->moves() != *moves) return;
    ask(*now, frame);
  }
  if (questions_.empty()) return;
  observe(camera, frame);
  const PoseResult pose = optimize_pose(frame.T_cw, observations_, camera, {.rounds = 2}, inlier_);
  if (!pose.ok || 2 * pose.inliers < observations_.size()) return;
  frame.T_cw = pose.T_cw;
  frame.information = pose.information;
}

}  // namespace covis
