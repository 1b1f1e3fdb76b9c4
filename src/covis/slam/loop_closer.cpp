// SPDX-License-Identifier: Apache-2.0
// Recognising a loop. The correction is in loop_correction.cpp.
#include "covis/slam/loop_closer.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "covis/core/random.h"
#include "covis/core/time.h"
#include "covis/matching/descriptor_match.h"
#include "covis/matching/point_geometry.h"

namespace covis {
namespace {

constexpr uint32_t kBetweenLoops = 10;  // key frames
constexpr size_t kCandidates = 3;       // places verified for a key frame
constexpr int kGroupMatching = 5;       // covisible key frames of a candidate matched against
constexpr int kGroupPoints = 15;        // covisible key frames of a candidate whose points are projected
constexpr float kRatio = 0.75f;

}  // namespace

bool LoopCloser::process(KeyFrameId current, LoopReport& report) {
  const Stopwatch watch;
  std::vector<KeyFrameId> places;
  View view;
  {
    const auto map = map_.read();
    const KeyFrame* key_frame = map->find(current);
    if (!key_frame || !key_frame->words) return false;
    if (last_loop_serial_ && key_frame->serial < *last_loop_serial_ + kBetweenLoops) return false;
    places = candidates(*map, current);
    report.query_ms = watch.ms();
    if (places.empty()) return false;
    view.copy(*map, current);
    camera_ = map->camera();
  }
  report.candidates = static_cast<int>(places.size());
  std::optional<Found> found;
  for (const KeyFrameId& place : places) {
    if ((found = verify(view, place, report))) break;
  }
  report.verify_ms = watch.ms() - report.query_ms;
  if (!found) return false;
  if (!found->elsewhere && nothing_to_correct(*found, report)) {
    fuse(view, *found, report);
    last_loop_serial_ = map_.read()->at(current).serial;
    return false;
  }
  if (found->elsewhere) {
    if (!join(view, *found, report)) return false;
    report.merged = true;
  } else {
    correct(view, *found, report);
  }
  report.loop = found->place.key_frame;
  fuse(view, *found, report);
  {
    const auto map = map_.write();
    map->add_loop_edge(current, found->place.key_frame);
    last_loop_serial_ = map->at(current).serial;
  }
  report.correct_ms = watch.ms() - report.query_ms - report.verify_ms;
  return true;
}

std::vector<KeyFrameId> LoopCloser::candidates(const Map& map, KeyFrameId current) const {
  const KeyFrame& key_frame = map.at(current);
  double min_score = 1;
  std::vector<KeyFrameId> excluded{current};
  for (const Neighbour& n : map.neighbours(current)) {
    excluded.push_back(n.key_frame);
    min_score = std::min(min_score, word_score(key_frame.words->words, map.at(n.key_frame).words->words));
  }
  std::sort(excluded.begin(), excluded.end());
  std::vector<KeyFrameId> result;
  for (const auto& candidate : map.database().query(map, *key_frame.words, excluded, min_score)) {
    // What was mapped a moment ago is no place come back to.
    const KeyFrame& place = map.at(candidate.key_frame);
    if (place.submap == key_frame.submap && place.serial + kBetweenLoops > key_frame.serial) continue;
    if (result.size() < kCandidates) result.push_back(candidate.key_frame);
  }
  return result;
}

LoopCloser::Place LoopCloser::copy_place(const Map& map, KeyFrameId id) const {
  Place place{id, map.at(id).T_cw, {id}, {}};
  for (const Neighbour& n : map.best_neighbours(id, kGroupPoints)) place.group.push_back(n.key_frame);
  place.points.id = points_of(map, place.group);
  place.points.copy(map);
  return place;
}

// Points of the key frame against points of the place, by descriptor: for each feature the most alike of all the
// group's features.
std::vector<Sim3Match> LoopCloser::match_points(const View& current, const Place& place) const {
  std::vector<MapPointId> matched(current.points.size());
  std::vector<int> distance(current.points.size(), 257);
  const std::vector<uint8_t> has_point = features_with_point(current.points);
  const auto map = map_.read();
  for (size_t g = 0; g < place.group.size() && g <= kGroupMatching; ++g) {
    const KeyFrame* member = map->find(place.group[g]);
    if (!member) continue;
    for (const FeatureMatch& m : match_descriptors(*current.features, has_point, *member->features,
                                                   features_with_point(member->points), {.max_distance = kHammingLow, .ratio = kRatio})) {
      const auto a = static_cast<size_t>(m.a), b = static_cast<size_t>(m.b);
      const int d = hamming(current.features->descriptor[a], member->features->descriptor[b]);
      if (d >= distance[a] || member->points[b] == current.points[a]) continue;
      distance[a] = d;
      matched[a] = member->points[b];
    }
  }
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
    // Others of the group may see the point where the key frame itself does not: its place there is where it projects.
    m.z_1 = {f.x[i], f.y[i]};
    m.z_2 = camera_.project(m.p_2);
    const int level = f.pyramid->predict_level(place.points.d_max[p], static_cast<float>(m.p_2.norm()));
    m.inv_sigma2_1 = f.pyramid->inv_sigma2[f.level[i]];
    m.inv_sigma2_2 = f.pyramid->inv_sigma2[static_cast<size_t>(level)];
    matches.push_back(m);
  }
  return matches;
}

LoopCloser::Projection LoopCloser::project(const Place& place, const View& view, const SE3& T_cw, double window) {
  const int in_view = matcher_.match(place.points, {camera_, *view.features, T_cw}, MatchGate::loop(window));
  return {in_view, matcher_.matches()};
}

bool LoopCloser::refine(const Place& place, const View& view, SE3& T_cw, Projection& projection) const {
  const Features& f = *view.features;
  PoseObservations observations;
  for (const auto& [feature, p] : projection.matches) {
    observations.add(place.points.position(p), f.x[feature], f.y[feature], f.u_right[feature],
                     f.pyramid->inv_sigma2[f.level[feature]]);
  }
  std::vector<uint8_t> inlier;
  const PoseResult pose = optimize_pose(T_cw, observations, camera_, {}, inlier);
  if (!pose.ok) return false;
  T_cw = pose.T_cw;
  size_t kept = 0;
  for (size_t k = 0; k < inlier.size(); ++k) {
    if (inlier[k]) projection.matches[kept++] = projection.matches[k];
  }
  projection.matches.resize(kept);
  return true;
}

std::optional<LoopCloser::Found> LoopCloser::verify(const View& current, KeyFrameId candidate, LoopReport& report) {
  const LoopOptions& o = options_.loop;
  Found found;
  {
    const auto map = map_.read();
    found.place = copy_place(*map, candidate);
    found.elsewhere = map->at(candidate).submap != map->at(current.id).submap;
  }
  const Place& place = found.place;
  const std::vector<Sim3Match> matches = match_points(current, place);
  report.matches = std::max(report.matches, static_cast<int>(matches.size()));
  if (static_cast<int>(matches.size()) < o.min_matches) return std::nullopt;
  const uint64_t seed = hash_seed(static_cast<uint64_t>(options_.seed), 3, candidate.slot);
  const auto start = ransac_sim3(matches, camera_, camera_, !monocular(), seed, o.min_inliers);
  if (!start) return std::nullopt;
  std::vector<Sim3Match> agreeing;
  for (size_t k = 0; k < matches.size(); ++k) {
    if (start->inlier[k]) agreeing.push_back(matches[k]);
  }
  const Sim3Result fine = refine_sim3(start->S_12, agreeing, camera_, camera_, !monocular());
  report.inliers = std::max(report.inliers, fine.inliers);
  if (!fine.ok || fine.inliers < o.min_inliers) return std::nullopt;

  // Twice, the second time from a better pose and so in narrower windows. The scale is the similarity's: what is
  // refined here is the pose in the old place's unit.
  const double scale = fine.S_12.scale();
  SE3 T_cw = (fine.S_12 * Sim3(place.T_cw)).as_pose();
  Projection projection;
  for (const double window : {10.0, 4.0}) {
    projection = project(place, current, T_cw, window);
    if (static_cast<int>(projection.matches.size()) < o.min_inliers || !refine(place, current, T_cw, projection))
      return std::nullopt;
  }
  const int count = static_cast<int>(projection.matches.size());
  report.found_again = std::max(report.found_again, count);
  const int least = found.elsewhere ? o.merge_min_found : o.min_found;
  const double least_share = found.elsewhere ? o.merge_min_found_share : o.min_found_share;
  if (count < least || count < least_share * projection.in_view) return std::nullopt;
  if (tied_already(current, place, projection)) return std::nullopt;
  found.S_cw = Sim3(T_cw.R(), scale * T_cw.t(), scale);
  for (const auto& [feature, p] : projection.matches) found.matches.emplace_back(feature, place.points.id[p]);
  const auto map = map_.read();
  if (!neighbours_agree(*map, current, found)) return std::nullopt;
  if (found.elsewhere) {
    report.scale = found.S_cw.scale();
    if (!seen_from_there(*map, current, found)) return std::nullopt;
  } else if (!drift_explains(*map, current, found, report)) {
    return std::nullopt;
  }
  return found;
}

// Most of what is found again is what the key frame has: the map leads from there to here without a gap.
bool LoopCloser::tied_already(const View& current, const Place& place, const Projection& projection) {
  const auto shared = std::count_if(projection.matches.begin(), projection.matches.end(), [&](const auto& match) {
    return current.points[match.feature] == place.points.id[match.point];
  });
  return 2 * static_cast<size_t>(shared) > projection.matches.size();
}

// A key frame beside one that is tied may see less of the other place: half as many points will do.
bool LoopCloser::enough_for_neighbour(const Projection& projection) const {
  const auto found = static_cast<double>(projection.matches.size());
  return found >= options_.loop.min_found / 2 && found >= options_.loop.min_found_share * projection.in_view;
}

// The other way round: the views of the place must find the points of the current key frame and of those round it.
// Things that are there and here are seen from both; of what is only alike each side sees more than the other has.
bool LoopCloser::seen_from_there(const Map& map, const View& current, const Found& found) {
  constexpr int kAsked = 3;
  const Place here = copy_place(map, current.id);
  const Sim3 S_wc = found.S_cw.inverse() * Sim3(current.T_cw);  // of the worlds: the current one's to the place's
  for (int k = 0; k < kAsked && k < static_cast<int>(found.place.group.size()); ++k) {
    const View view(map, found.place.group[static_cast<size_t>(k)]);
    const Projection projection = project(here, view, (Sim3(view.T_cw) * S_wc).as_pose(), 8);
    if (!enough_for_neighbour(projection)) return false;
  }
  return true;
}

// The best covisible key frames, moved along with the current one, must find the place's points too: two of the first
// five, or as many as there are; to join submaps there must be one at least.
bool LoopCloser::neighbours_agree(const Map& map, const View& current, const Found& found) {
  constexpr int kAsked = 5, kWanted = 2;
  int asked = 0, agree = 0;
  for (const Neighbour& n : map.best_neighbours(current.id, kAsked)) {
    const View view(map, n.key_frame);
    const Sim3 S_nw = Sim3(view.T_cw * current.T_cw.inverse()) * found.S_cw;
    const Projection projection = project(found.place, view, S_nw.as_pose(), 8);
    ++asked;
    agree += enough_for_neighbour(projection);
  }
  return agree >= std::max(std::min(asked, kWanted), found.elsewhere ? 1 : 0);
}

// A place seen again whose correction would move its points by no more than two pixels: the camera looked away for a
// moment. Its points are made one, but there is no drift to take out.
bool LoopCloser::nothing_to_correct(const Found& found, const LoopReport& report) const {
  constexpr double kPixels = 2;
  std::vector<double> depths;
  const SE3 T_cw = found.S_cw.as_pose();
  for (const auto& [feature, id] : found.matches) {
    depths.push_back((T_cw * found.place.points.position(static_cast<size_t>(index_of(found.place.points, id)))).z());
  }
  const auto middle = depths.begin() + static_cast<ptrdiff_t>(depths.size() / 2);
  std::nth_element(depths.begin(), middle, depths.end());
  const double angle = report.correction / std::max(*middle, 1e-9) + report.rotation_deg * std::numbers::pi / 180;
  return angle * camera_.fx < kPixels && std::abs(std::log(report.scale)) < 0.005;
}

bool LoopCloser::drift_explains(const Map& map, const View& current, const Found& found, LoopReport& report) const {
  const uint32_t first = map.at(found.place.key_frame).serial, last = map.at(current.id).serial;
  double path = 0;
  std::optional<Eigen::Vector3d> before;
  for (const KeyFrameId& id : map.key_frames(map.at(current.id).submap)) {
    const KeyFrame& key_frame = map.at(id);
    if (key_frame.serial < std::min(first, last) || key_frame.serial > std::max(first, last)) continue;
    const Eigen::Vector3d centre = key_frame.T_cw.centre();
    if (before) path += (centre - *before).norm();
    before = centre;
  }
  const SE3 corrected = found.S_cw.as_pose();
  report.path = path;
  report.correction = (corrected.centre() - current.T_cw.centre()).norm();
  report.rotation_deg = so3_log(corrected.R() * current.T_cw.R().transpose()).norm() * 180 / std::numbers::pi;
  report.scale = found.S_cw.scale();
  const double share = monocular() ? options_.loop.max_drift_mono : options_.loop.max_drift;
  return report.correction <= share * path && report.rotation_deg <= options_.loop.max_rotation &&
         std::abs(std::log(report.scale)) <= std::log(options_.loop.max_scale);
}

}  // namespace covis
