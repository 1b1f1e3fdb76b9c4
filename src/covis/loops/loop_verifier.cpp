// SPDX-License-Identifier: Apache-2.0
#include "covis/loops/loop_verifier.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "covis/core/quantile.h"
#include "covis/core/random.h"
#include "covis/matching/descriptor_match.h"
#include "covis/matching/point_geometry.h"
#include "covis/optimization/pose_optimization.h"

namespace covis {
namespace {

constexpr size_t kGroupMatching = 6;  // key frames of a place that are matched against
constexpr int kGroupPoints = 15;      // covisible key frames of a place whose points are projected
constexpr int kNeighbours = 5;        // key frames beside the current one that are asked
constexpr float kRatio = 0.75f;

// The way along the key frames between two of one submap, in the map's unit.
double path_between(const Map& map, KeyFrameId a, KeyFrameId b) {
  const auto [first, last] = std::minmax(map.at(a).serial, map.at(b).serial);
  double path = 0;
  std::optional<Eigen::Vector3d> before;
  for (const KeyFrameId& id : map.key_frames(map.at(a).submap)) {
    const KeyFrame& key_frame = map.at(id);
    if (key_frame.serial < first || key_frame.serial > last) continue;
    const Eigen::Vector3d centre = key_frame.T_cw.centre();
    if (before) path += (centre - *before).norm();
    before = centre;
  }
  return path;
}

// For each feature of the current key frame the place's point that looks most like it, or an invalid handle.
std::vector<MapPointId> match_descriptors(const LoopCandidate& candidate) {
  const KeyFrameView& current = candidate.current;
  std::vector<MapPointId> matched(current.points.size());
  std::vector<int> distance(current.points.size(), kHammingBeyond);
  const std::vector<uint8_t> has_point = features_with_point(current.points);
  for (const KeyFrameView& member : candidate.members) {
    for (const FeatureMatch& m :
         match_descriptors(*current.features, has_point, *member.features, features_with_point(member.points),
                           {.max_distance = kHammingLow, .ratio = kRatio})) {
      const auto a = static_cast<size_t>(m.a), b = static_cast<size_t>(m.b);
      const int d = hamming(current.features->descriptor[a], member.features->descriptor[b]);
      if (d >= distance[a] || member.points[b] == current.points[a]) continue;
      distance[a] = d;
      matched[a] = member.points[b];
    }
  }
  return matched;
}

// Points of the key frame against points of the place.
std::vector<Sim3Match> match_points(const LoopCandidate& candidate) {
  const LoopPlace& place = candidate.place;
  const KeyFrameView& current = candidate.current;
  const std::vector<MapPointId> matched = match_descriptors(candidate);
  std::vector<Sim3Match> matches;
  const Features& f = *current.features;
  for (size_t i = 0; i < matched.size(); ++i) {
    if (!matched[i].valid()) continue;
    const int32_t at = index_of(place.points, matched[i]);
    if (at < 0) continue;
    const auto p = static_cast<size_t>(at);
    Sim3Match m;
    m.p_1 = current.T_cw * current.positions[i];
    m.p_2 = place.T_cw * place.points.position(p);
    if (!(m.p_1.z() > 0) || !(m.p_2.z() > 0)) continue;
    // Others of the group may see the point where the key frame itself does not: its measurement there is taken to be
    // its projection.
    m.z_1 = {f.x[i], f.y[i]};
    m.z_2 = candidate.camera.project(m.p_2);
    const int level = f.pyramid->predict_level(place.points.d_max[p], static_cast<float>(m.p_2.norm()));
    m.inv_sigma2_1 = f.pyramid->inv_sigma2[f.level[i]];
    m.inv_sigma2_2 = f.pyramid->inv_sigma2[static_cast<size_t>(level)];
    matches.push_back(m);
  }
  return matches;
}

// Refines the pose on the matches and keeps those that agree. False when it can't.
bool refine(const LoopPlace& place, const Pinhole& camera, const Features& f, SE3& T_cw,
            std::vector<PointMatch>& matches) {
  PoseObservations observations;
  for (const auto& [feature, p] : matches) {
    observations.add(place.points.position(p), f.x[feature], f.y[feature], f.pyramid->inv_sigma2[f.level[feature]],
                     disparity_of(f, feature, camera));
  }
  std::vector<uint8_t> inlier;
  const PoseResult pose = optimize_pose(T_cw, observations, camera, {}, inlier);
  if (!pose.ok) return false;
  T_cw = pose.T_cw;
  size_t kept = 0;
  for (size_t k = 0; k < inlier.size(); ++k) {
    if (inlier[k]) matches[kept++] = matches[k];
  }
  matches.resize(kept);
  return true;
}

// More than half of the matches are points the key frame already observes: covisible, not a loop.
bool tied_already(const LoopCandidate& candidate, const std::vector<PointMatch>& matches) {
  const auto shared = std::count_if(matches.begin(), matches.end(), [&](const PointMatch& match) {
    return candidate.current.points[match.feature] == candidate.place.points.id[match.point];
  });
  return 2 * static_cast<size_t>(shared) > matches.size();
}

LoopDrift drift_of(const LoopCandidate& candidate, const Sim3& S_cw) {
  LoopDrift drift{.scale = S_cw.scale()};
  if (candidate.relation == LoopRelation::other_submap) return drift;
  const SE3& before = candidate.current.T_cw;
  const SE3 corrected = S_cw.as_pose();
  drift.path = candidate.path;
  drift.distance = (corrected.centre() - before.centre()).norm();
  drift.rotation_deg = so3_log(corrected.R() * before.R().transpose()).norm() * 180 / std::numbers::pi;
  return drift;
}

}  // namespace

LoopPlace::LoopPlace(const Map& map, KeyFrameId id) : key_frame(id), T_cw(map.at(id).T_cw), group{id} {
  for (const Neighbour& n : map.best_neighbours(id, kGroupPoints)) group.push_back(n.key_frame);
  points.id = points_of(map, group);
  points.copy(map);
}

LoopCandidate::LoopCandidate(const Map& map, KeyFrameId from, KeyFrameId to)
    : camera(map.camera()), frame(map.at(from).frame), current(map, from), place(map, to) {
  for (size_t g = 0; g < place.group.size() && g < kGroupMatching; ++g) members.emplace_back(map, place.group[g]);
  for (const Neighbour& n : map.best_neighbours(from, kNeighbours)) neighbours.emplace_back(map, n.key_frame);
  if (map.at(from).submap == map.at(to).submap) {
    path = path_between(map, from, to);
  } else {
    relation = LoopRelation::other_submap;
    here.emplace(map, from);
  }
}

LoopVerdict LoopVerifier::verify(const LoopCandidate& candidate) {
  const bool elsewhere = candidate.relation == LoopRelation::other_submap;
  LoopVerdict verdict;
  const auto refused = [&](LoopRefusal why) {
    verdict.refusal = why;
    return std::move(verdict);
  };
  const std::vector<Sim3Match> matches = match_points(candidate);
  verdict.evidence.matches = static_cast<int>(matches.size());
  if (verdict.evidence.matches < options_.min_matches) return refused(LoopRefusal::few_matches);
  const std::optional<Sim3> S_12 = similarity(matches, candidate, verdict.evidence);
  if (!S_12) return refused(LoopRefusal::no_similarity);

  // The scale is the similarity's: the pose is refined in the old place's unit.
  SE3 T_cw = (*S_12 * Sim3(candidate.place.T_cw)).as_pose();
  const std::optional<Projection> again = find_again(candidate, T_cw);
  if (!again) return refused(LoopRefusal::not_found_again);
  const int count = static_cast<int>(again->matches.size());
  verdict.evidence.found_again = count;
  if (count < (elsewhere ? options_.merge_min_found : options_.min_found)) return refused(LoopRefusal::not_found_again);
  if (count < (elsewhere ? options_.merge_min_found_share : options_.min_found_share) * again->in_view)
    return refused(LoopRefusal::small_share);
  if (tied_already(candidate, again->matches)) return refused(LoopRefusal::tied_already);

  const Sim3 S_cw(T_cw.R(), S_12->scale() * T_cw.t(), S_12->scale());
  if (!neighbours_agree(candidate, S_cw)) return refused(LoopRefusal::neighbours_disagree);
  verdict.drift = drift_of(candidate, S_cw);
  if (elsewhere && !seen_from_there(candidate, S_cw)) return refused(LoopRefusal::not_seen_from_there);
  if (!elsewhere && !drift_explains(*verdict.drift)) return refused(LoopRefusal::drift_too_great);
  Loop& loop = verdict.loop.emplace(Loop{candidate.place, candidate.relation, S_cw, {}});
  for (const auto& [feature, p] : again->matches) loop.matches.emplace_back(feature, candidate.place.points.id[p]);
  return verdict;
}

std::optional<Sim3> LoopVerifier::similarity(const std::vector<Sim3Match>& matches, const LoopCandidate& candidate,
                                             LoopEvidence& evidence) const {
  const Pinhole& camera = candidate.camera;
  const uint64_t seed =
      hash_seed(static_cast<uint64_t>(seed_), RandomStage::loops, static_cast<uint64_t>(candidate.frame));
  const auto start = ransac_sim3(matches, camera, camera, !monocular(), seed, options_.min_inliers);
  if (!start) return std::nullopt;
  std::vector<Sim3Match> agreeing;
  for (size_t k = 0; k < matches.size(); ++k) {
    if (start->inlier[k]) agreeing.push_back(matches[k]);
  }
  const Sim3Result fine = refine_sim3(start->S_12, agreeing, camera, camera, !monocular());
  evidence.inliers = fine.inliers;
  if (!fine.ok || fine.inliers < options_.min_inliers) return std::nullopt;
  return fine.S_12;
}

LoopVerifier::Projection LoopVerifier::project(const LoopPlace& place, const Pinhole& camera, const KeyFrameView& view,
                                               const SE3& T_cw, double window) {
  const int in_view = matcher_.match(place.points, {camera, *view.features, T_cw}, MatchGate::loop(window));
  return {in_view, matcher_.matches()};
}

// Twice, the second time from a better pose and so in narrower windows.
std::optional<LoopVerifier::Projection> LoopVerifier::find_again(const LoopCandidate& candidate, SE3& T_cw) {
  constexpr double kWindows[] = {10, 4};  // pixels x scale
  Projection projection;
  for (const double window : kWindows) {
    projection = project(candidate.place, candidate.camera, candidate.current, T_cw, window);
    if (static_cast<int>(projection.matches.size()) < options_.min_inliers) return std::nullopt;
    if (!refine(candidate.place, candidate.camera, *candidate.current.features, T_cw, projection.matches))
      return std::nullopt;
  }
  return projection;
}

// A key frame beside one that is tied may see less of the other place: half as many points will do.
bool LoopVerifier::enough_for_neighbour(const Projection& projection) const {
  const auto found = static_cast<double>(projection.matches.size());
  return found >= options_.min_found / 2 && found >= options_.min_found_share * projection.in_view;
}

// The best covisible key frames, moved along with the current one, must find the place's points too: two of the first
// five, or as many as there are; to join submaps there must be one at least.
bool LoopVerifier::neighbours_agree(const LoopCandidate& candidate, const Sim3& S_cw) {
  constexpr int kWanted = 2;
  int agree = 0;
  for (const KeyFrameView& view : candidate.neighbours) {
    const Sim3 S_nw = Sim3(view.T_cw * candidate.current.T_cw.inverse()) * S_cw;
    agree += enough_for_neighbour(project(candidate.place, candidate.camera, view, S_nw.as_pose(), 8));
  }
  const int least = candidate.relation == LoopRelation::other_submap ? 1 : 0;
  return agree >= std::max(std::min(static_cast<int>(candidate.neighbours.size()), kWanted), least);
}

// The other way around: the views of the place must find the points of the current key frame and of those around it. A
// scene that is here and there is seen from both; of two that are only alike each side sees more than the other has.
bool LoopVerifier::seen_from_there(const LoopCandidate& candidate, const Sim3& S_cw) {
  constexpr size_t kAsked = 3;
  const Sim3 S_wc = S_cw.inverse() * Sim3(candidate.current.T_cw);  // from the current world to the place's
  for (size_t k = 0; k < kAsked && k < candidate.members.size(); ++k) {
    const KeyFrameView& view = candidate.members[k];
    const SE3 T_cw = (Sim3(view.T_cw) * S_wc).as_pose();
    if (!enough_for_neighbour(project(*candidate.here, candidate.camera, view, T_cw, 8))) return false;
  }
  return true;
}

bool LoopVerifier::drift_explains(const LoopDrift& drift) const {
  return drift.distance <= options_.drift(sensor_) * drift.path && drift.rotation_deg <= options_.max_rotation &&
         std::abs(std::log(drift.scale)) <= std::log(options_.max_scale);
}

bool nothing_to_correct(const Loop& loop, const LoopDrift& drift, const Pinhole& camera) {
  constexpr double kPixels = 2;
  std::vector<double> depths;
  const SE3 T_cw = loop.S_cw.as_pose();
  for (const auto& [feature, id] : loop.matches) {
    const int32_t at = index_of(loop.place.points, id);
    depths.push_back((T_cw * loop.place.points.position(static_cast<size_t>(at))).z());
  }
  const double median = quantile(std::move(depths), 0.5);
  const double angle = drift.distance / std::max(median, 1e-9) + drift.rotation_deg * std::numbers::pi / 180;
  return angle * camera.fx < kPixels && std::abs(std::log(drift.scale)) < 0.005;
}

}  // namespace covis
