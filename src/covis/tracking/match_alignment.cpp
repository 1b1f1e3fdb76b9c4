// SPDX-License-Identifier: Apache-2.0
#include "covis/tracking/match_alignment.h"

#include <algorithm>
#include <optional>

#include "covis/matching/point_geometry.h"

namespace covis {

// Reserves room in advance; its memory is used only when matches come.
MatchAlignment::MatchAlignment() {
  constexpr size_t kFeatures = 1 << 12;
  views_.reserve(kFeatures);
  questions_.reserve(kFeatures);
  observations_.reserve(kFeatures);
  inlier_.reserve(kFeatures);
}

// Copies what the map knows, so that no guard is held while matches are aligned.
void MatchAlignment::ask(const Map& map, const Pinhole& camera, const TrackedFrame& frame) {
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
    add(camera, frame, i, *reference.features, point->feature_in(last), reference.T_cw * point->position_w, T_vr);
  }
}

void MatchAlignment::add(const Pinhole& camera, const TrackedFrame& frame, size_t feature, const Features& reference,
                         size_t seen, const Eigen::Vector3d& p_r, const SE3& T_vr) {
  const auto question = PatchQuestion::of(camera, reference, seen, p_r, T_vr, *frame.features, feature);
  if (question) questions_.push_back({static_cast<uint32_t>(feature), *question});
}

void MatchAlignment::keep_views(const Map& map, const PointSet& points) {
  references_.clear();
  views_.clear();
  for (const MapPointId id : points.id) {
    const MapPoint* point = map.find(id);
    if (!point) continue;
    auto at = std::ranges::find(references_, point->reference, &Reference::id);
    const KeyFrame& reference = map.at(point->reference);
    if (!reference.features->patches) continue;
    if (at == references_.end()) {
      references_.push_back({point->reference, reference.features, reference.T_cw, {}});
      at = references_.end() - 1;
    }
    views_.push_back({id, static_cast<uint32_t>(at - references_.begin()), point->feature_in(at->id),
                      reference.T_cw * point->position_w});
  }
  std::ranges::sort(views_, {}, &View::point);
}

const MatchAlignment::View* MatchAlignment::kept_view(MapPointId point) const {
  const auto at = std::ranges::lower_bound(views_, point, {}, &View::point);
  return at != views_.end() && at->point == point ? &*at : nullptr;
}

void MatchAlignment::ask_kept(const Pinhole& camera, const TrackedFrame& frame) {
  questions_.clear();
  for (Reference& reference : references_) reference.T_vr = frame.T_cw * reference.T_cw.inverse();
  for (size_t i = 0; i < frame.source.size(); ++i) {
    const View* view = frame.on_map(i) ? kept_view(frame.points[i]) : nullptr;
    if (!view) continue;
    const Reference& reference = references_[view->reference];
    add(camera, frame, i, *reference.features, view->feature, view->p_r, reference.T_vr);
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

void MatchAlignment::refine_pose(const SharedMap* live, const Pinhole& camera, std::optional<uint64_t> moves,
                                 TrackedFrame& frame) {
  if (!frame.features->patches) return;
  if (live) {
    const auto map = live->read();
    if (moves && map->moves() != *moves) return;
    ask(*map, camera, frame);
  } else {
    ask_kept(camera, frame);
  }
  if (questions_.empty()) return;
  observe(camera, frame);
  const PoseResult pose = optimize_pose(frame.T_cw, observations_, camera, {.rounds = 2}, inlier_);
  if (!pose.ok || 2 * pose.inliers < observations_.size()) return;
  frame.T_cw = pose.T_cw;
  frame.information = pose.information;
}

}  // namespace covis
