// SPDX-License-Identifier: Apache-2.0
#include "covis/loops/loop_verifier.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "covis/core/quantile.h"
#include "covis/core/random.h"
#include "covis/loops/drift_prior.h"
#include "covis/loops/loop_matches.h"
#include "covis/matching/point_geometry.h"
#include "covis/optimization/pose_optimization.h"

namespace covis {
namespace {

constexpr size_t kViewsThere = 3;  // views of the place that are asked about a relation of which nothing else is known

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

LoopDrift drift_of(const LoopCandidate& candidate, const Loop& loop) {
  const Sim3& S_cw = loop.S_cw;
  LoopDrift drift{.scale = S_cw.scale()};
  if (candidate.relation == LoopRelation::other_submap) return drift;
  const SE3& before = candidate.current.T_cw;
  const SE3 corrected = S_cw.as_pose();
  drift.path = candidate.travel.length;
  drift.past = candidate.travel.past(S_cw.scale() * median_depth(loop));
  drift.distance = (corrected.centre() - before.centre()).norm();
  drift.rotation_deg = so3_log(corrected.R() * before.R().transpose()).norm() * 180 / std::numbers::pi;
  return drift;
}

// Shares of what is expected, measured in docs/notes/032-merging-maps.md.
bool shows_as_expected(const ExpectedMatches& found) {
  if (found.from_here.enough()) return found.from_here.reaches(0.3);
  return found.from_near.enough() && found.from_near.reaches(0.15) && found.young_too.reaches(0.1);
}

bool shows_next_to_nothing(const ExpectedMatches& found) {
  constexpr double kSaysMuch = 200;  // matches expected from near there, where few are from there itself
  if (found.from_here.enough() && !found.from_here.reaches(0.2)) return true;
  return found.from_near.expected >= kSaysMuch && !found.from_near.reaches(0.1);
}

}  // namespace

LoopVerdict LoopVerifier::verify(const LoopCandidate& candidate) {
  const bool elsewhere = candidate.relation == LoopRelation::other_submap;
  LoopVerdict verdict;
  const auto refused = [&](LoopRefusal why) {
    verdict.refusal = why;
    return std::move(verdict);
  };
  const std::vector<Sim3Match> matches = match_by_descriptor(candidate);
  verdict.evidence.matches = static_cast<int>(matches.size());
  if (verdict.evidence.matches < options_.min_matches) return refused(LoopRefusal::few_matches);
  const std::optional<Sim3> S_12 = similarity(matches, candidate, verdict.evidence);
  if (!S_12) return refused(LoopRefusal::no_similarity);

  Sim3 S_cw = *S_12 * Sim3(candidate.place.T_cw);
  const std::optional<Projection> again = find_again(candidate, S_cw, verdict.evidence);
  if (!again || again->count() < (elsewhere ? options_.merge_min_found : options_.min_found))
    return refused(LoopRefusal::not_found_again);
  if (!shows_enough(candidate.place, *again, elsewhere ? options_.merge_min_found_share : options_.min_found_share))
    return refused(LoopRefusal::small_share);
  if (tied_already(candidate, again->matches)) return refused(LoopRefusal::tied_already);
  std::optional<Matrix7d> information;
  if (monocular() || !elsewhere) information = refine_on_views(candidate, S_cw);

  Loop loop{candidate.place, candidate.relation, S_cw, {}, {}, information};
  for (const auto& [feature, p] : again->matches) loop.matches.emplace_back(feature, candidate.place.points.id[p]);
  loop.drift = drift_of(candidate, loop);
  verdict.drift = loop.drift;
  const bool explained = elsewhere || drift_explains(*verdict.drift);
  if (!neighbours_agree(candidate, S_cw)) {
    // Those that come later may: the camera has only just turned to the place.
    if (!elsewhere && explained && seen_from_there(candidate, S_cw, 1)) verdict.claim = std::move(loop);
    return refused(LoopRefusal::neighbours_disagree);
  }
  if (elsewhere && !seen_from_there(candidate, S_cw, kViewsThere)) return refused(LoopRefusal::not_seen_from_there);
  if (!explained) {
    // The path since says nothing, as if the place were another submap's.
    const bool enough = again->count() >= options_.merge_min_found && again->share() >= options_.merge_min_found_share;
    if (enough && seen_from_there(candidate, S_cw, kViewsThere)) verdict.claim = std::move(loop);
    return refused(LoopRefusal::drift_too_great);
  }
  verdict.loop = std::move(loop);
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
  return {in_view, matcher_.matches(), T_cw, map_ ? matcher_.in_view() : std::vector<uint8_t>()};
}

// Twice, the second time from a better pose and so in narrower windows. Each time the similarity, whose scale the few
// matches by descriptor hardly tell, is refined on what both sides find of each other, and then the pose, in the old
// place's unit, on what is found here, which may have no point of its own yet, and has its depth.
std::optional<LoopVerifier::Projection> LoopVerifier::find_again(const LoopCandidate& candidate, Sim3& S_cw,
                                                                 LoopEvidence& evidence) {
  constexpr double kWindows[] = {10, 4};  // pixels x scale
  Projection projection;
  for (const double window : kWindows) {
    projection = project(candidate.place, candidate.camera, candidate.current, S_cw.as_pose(), window);
    evidence.found_again = projection.count();
    evidence.in_view = projection.in_view;
    if (projection.count() < options_.min_inliers) return std::nullopt;
    refine_both_ways(candidate, projection, window, S_cw, evidence);
    SE3 T_cw = S_cw.as_pose();
    if (!refine(candidate.place, candidate.camera, *candidate.current.features, T_cw, projection.matches))
      return std::nullopt;
    projection.T_cw = T_cw;
    S_cw = Sim3(T_cw.R(), S_cw.scale() * T_cw.t(), S_cw.scale());
    evidence.found_again = projection.count();
  }
  return projection;
}

void LoopVerifier::refine_both_ways(const LoopCandidate& candidate, const Projection& here, double window, Sim3& S_cw,
                                    LoopEvidence& evidence) {
  const KeyFrameView& view = candidate.members.front();
  const Sim3 S_wc = S_cw.inverse() * Sim3(candidate.current.T_cw);  // from the current world to the place's
  const SE3 T_view = (Sim3(view.T_cw) * S_wc).as_pose();
  const Projection there = project(candidate.here, candidate.camera, view, T_view, window);
  const std::vector<Sim3Match> matches = match_both_ways(candidate, here.matches, there.matches);
  const Sim3 S_12 = S_cw * Sim3(view.T_cw.inverse());
  const Sim3Result fine = refine_sim3(S_12, matches, candidate.camera, candidate.camera, !monocular());
  evidence.both_ways = fine.inliers;
  if (fine.ok && fine.inliers >= options_.min_inliers) S_cw = fine.S_12 * Sim3(view.T_cw);
}

std::optional<Matrix7d> LoopVerifier::refine_on_views(const LoopCandidate& candidate, Sim3& S_cw) {
  constexpr double kWindow = 4;  // pixels x scale
  using Way = CarriedPoint::Way;
  std::vector<CarriedPoint> points;
  const auto add = [&](Way way, const Eigen::Vector3d& p, const SE3& T, const Features& f, uint32_t feature) {
    points.push_back({way, p, T, {f.x[feature], f.y[feature]}, f.pyramid->inv_sigma2[f.level[feature]]});
  };
  const SE3& T_cw = candidate.current.T_cw;
  const auto see_place = [&](const KeyFrameView& view) {
    const SE3 T_vc = view.T_cw * T_cw.inverse();
    const SE3 T_view = (Sim3(T_vc) * S_cw).as_pose();
    for (const auto& [feature, p] : project(candidate.place, candidate.camera, view, T_view, kWindow).matches)
      add(Way::forth, candidate.place.points.position(p), T_vc, *view.features, feature);
  };
  see_place(candidate.current);
  for (const KeyFrameView& view : candidate.neighbours) see_place(view);
  const Sim3 S_wc = S_cw.inverse() * Sim3(T_cw);  // from the current world to the place's
  for (const KeyFrameView& view : candidate.members) {
    const SE3 T_view = (Sim3(view.T_cw) * S_wc).as_pose();
    for (const auto& [feature, p] : project(candidate.here, candidate.camera, view, T_view, kWindow).matches)
      add(Way::back, T_cw * candidate.here.points.position(p), view.T_cw, *view.features, feature);
  }
  const CarriedResult fine = refine_sim3(S_cw, points, candidate.camera, scale());
  if (!fine.ok || 2 * static_cast<size_t>(fine.agreeing) <= points.size()) return std::nullopt;
  if (monocular()) S_cw = fine.S;
  return fine.information;
}

ExpectedMatches LoopVerifier::expected(const LoopPlace& place, const Projection& projection) const {
  ExpectedMatches expected;
  std::vector<uint8_t> matched(place.points.size());
  for (const PointMatch& match : projection.matches) matched[match.point] = 1;
  const Eigen::Vector3d centre_w = projection.T_cw.centre();
  for (size_t p = 0; p < projection.visible.size(); ++p) {
    if (projection.visible[p]) expected.add(map_->at(place.points.id[p]), *map_, centre_w, matched[p]);
  }
  return expected;
}

bool LoopVerifier::shows_enough(const LoopPlace& place, const Projection& projection, double share) const {
  return projection.share() >= share || (map_ && shows_as_expected(expected(place, projection)));
}

// A key frame beside one that is tied may see less of the other place: half as many points will do.
bool LoopVerifier::enough_for_neighbour(const LoopPlace& place, const Projection& projection) const {
  return projection.count() >= options_.min_found / 2 && shows_enough(place, projection, options_.min_found_share);
}

// The best covisible key frames, moved along with the current one, must find the place's points too: two of the first
// five, or as many as there are; to join submaps there must be one at least.
bool LoopVerifier::neighbours_agree(const LoopCandidate& candidate, const Sim3& S_cw) {
  constexpr int kWanted = 2;
  const int least = candidate.relation == LoopRelation::other_submap ? 1 : 0;
  const int wanted = std::max(std::min(static_cast<int>(candidate.neighbours.size()), kWanted), least);
  int agree = 0;
  for (const KeyFrameView& view : candidate.neighbours) {
    if (agree == wanted) break;
    const Sim3 S_nw = Sim3(view.T_cw * candidate.current.T_cw.inverse()) * S_cw;
    agree += enough_for_neighbour(candidate.place, project(candidate.place, candidate.camera, view, S_nw.as_pose(), 8));
  }
  return agree == wanted;
}

// The other way around: the views of the place must find the points of the current key frame and of those around it. A
// scene that is here and there is seen from both; of two that are only alike each side sees more than the other has.
bool LoopVerifier::seen_from_there(const LoopCandidate& candidate, const Sim3& S_cw, size_t views) {
  const Sim3 S_wc = S_cw.inverse() * Sim3(candidate.current.T_cw);  // from the current world to the place's
  for (size_t k = 0; k < views && k < candidate.members.size(); ++k) {
    const KeyFrameView& view = candidate.members[k];
    const SE3 T_cw = (Sim3(view.T_cw) * S_wc).as_pose();
    if (!enough_for_neighbour(candidate.here, project(candidate.here, candidate.camera, view, T_cw, 8))) return false;
  }
  return true;
}

LoopVerifier::View LoopVerifier::look_for(const LoopPlace& place, const Pinhole& camera, const KeyFrameView& view,
                                          const SE3& T_cw) {
  const Projection seen = project(place, camera, view, T_cw, 8);
  if (seen.in_view < 2 * options_.min_found) return View::says_nothing;
  if (map_ && shows_next_to_nothing(expected(place, seen))) return View::contradicts;
  return enough_for_neighbour(place, seen) ? View::agrees : View::disagrees;
}

bool LoopVerifier::drift_explains(const LoopDrift& drift) const {
  // By one camera the share is three times as great, and turns were not needed.
  const double way = monocular() ? drift.path : drift.past;
  return drift.distance <= options_.drift(sensor_) * way && drift.rotation_deg <= options_.max_rotation &&
         std::abs(std::log(drift.scale)) <= std::log(options_.max_scale);
}

LoopDrift weigh_against_drift(const LoopCandidate& candidate, Sensor sensor, Loop& loop) {
  if (candidate.relation == LoopRelation::other_submap || !loop.information) return drift_of(candidate, loop);
  const SE3& before = candidate.current.T_cw;
  const Scale scale = sensor == Sensor::monocular ? Scale::free : Scale::fixed;
  const double depth = loop.S_cw.scale() * median_depth(loop);
  const Sim3 correction = loop.S_cw * Sim3(before.inverse());
  const ExpectedDrift expected{candidate.travel.past(depth), depth, scale};
  loop.S_cw = weigh_against_drift(correction, *loop.information, expected) * Sim3(before);
  loop.information.reset();
  return drift_of(candidate, loop);
}

bool nothing_to_correct(const Loop& loop, const Pinhole& camera) {
  constexpr double kPixels = 2;
  const double angle =
      loop.drift.distance / std::max(median_depth(loop), 1e-9) + loop.drift.rotation_deg * std::numbers::pi / 180;
  return angle * camera.fx < kPixels && std::abs(std::log(loop.drift.scale)) < 0.005;
}

}  // namespace covis
