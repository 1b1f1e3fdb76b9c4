// SPDX-License-Identifier: Apache-2.0
// How a lost camera finds its place again (ORB-SLAM, V-C).
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "covis/core/time.h"
#include "covis/geometry/pnp.h"
#include "covis/slam/tracker.h"

namespace covis {

// The key frames the camera may be at: places that look alike, the reference and its neighbours, and a few of the
// others in turn.
std::vector<KeyFrameId> Tracker::recovery_candidates(const Map& map) {
  constexpr size_t kAlike = 8;
  constexpr int kNeighbours = 3, kOthers = 2, kOthersWithoutWords = 5;
  std::vector<KeyFrameId> candidates;
  const auto add = [&](KeyFrameId id) {
    if (std::find(candidates.begin(), candidates.end(), id) == candidates.end()) candidates.push_back(id);
  };
  if (vocabulary_) {
    const Words words = vocabulary_->transform(current_.features->descriptor);
    for (const auto& candidate : map.database().query(map, words, {}, 0)) {
      if (candidates.size() < kAlike) add(candidate.key_frame);
    }
  }
  if (const auto resolved = map.resolve(reference_)) {
    add(resolved->key_frame);
    for (const Neighbour& n : map.best_neighbours(resolved->key_frame, kNeighbours)) add(n.key_frame);
  }
  const std::vector<KeyFrameId> all = map.key_frames();
  const int others = vocabulary_ ? kOthers : kOthersWithoutWords;
  for (int k = 0; k < others && !all.empty(); ++k) add(all[recovery_cursor_++ % all.size()]);
  return candidates;
}

bool Tracker::recover(TrackResult& result, bool map_is_live) {
  const Stopwatch watch;
  bool found = false;
  if (!map_is_live) {
    found = local_map_.reference.features && recover_from(local_map_.reference, result, map_is_live);
  } else {
    KeyFrameView view;
    for (const KeyFrameId& candidate : recovery_candidates(*map_.read())) {
      {
        const auto map = map_.read();
        if (!map->find(candidate)) continue;
        view.copy(*map, candidate);
      }
      if ((found = recover_from(view, result, map_is_live))) break;
    }
    // The candidates leave nothing behind: the rest of the local map is made anew for each frame.
    if (const auto map = map_.read(); !found && map->find(reference_)) local_map_.reference.copy(*map, reference_);
  }
  result.motion_ms += watch.ms();
  if (found) {
    last_recovery_ = current_.stamp;
    result.method = TrackMethod::recovered;
  } else if (state_ == TrackState::lost) {
    result.reason = "lost: the view matches no key frame tried";
  }
  return found;
}

bool Tracker::recover_from(const KeyFrameView& view, TrackResult& result, bool map_is_live) {
  // Wider than for the next frame: RANSAC sorts out what is wrong. 5 % more frames are found than with 0.75 and 50.
  constexpr double kRatio = 0.9;
  constexpr int kMaxDistance = 64;
  constexpr int kMinPose = 10;  // inliers after which a search by projection is worth it
  const TrackerOptions& o = options_.tracker;
  if (match_key_frame(view, kRatio, kMaxDistance) < o.first_pose.reference_min_matches) return false;

  const Features& f = *current_.features;
  PnpProblem problem;
  std::vector<size_t> feature;
  for (size_t i = 0; i < current_.known.size(); ++i) {
    if (!current_.known[i]) continue;
    problem.add(current_.positions[i], camera_.unproject(f.x[i], f.y[i]), f.pyramid->sigma2[f.level[i]]);
    feature.push_back(i);
  }
  const auto pose =
      ransac_pnp(problem, camera_, static_cast<uint64_t>(options_.seed) + static_cast<uint64_t>(current_.index));
  if (!pose) return false;
  current_.T_cw = pose->T_cw;
  for (size_t k = 0; k < feature.size(); ++k) {
    if (!pose->inlier[k]) set_match(feature[k], {}, Eigen::Vector3d::Zero(), kNone);
  }
  if (optimize() < kMinPose) return false;
  // Twice: the second search starts from a better pose.
  for (int round = 0; round < 2; ++round) {
    if (map_is_live) update_local_map(view.id);
    result.local_in_view = search_local_map(round == 0 ? 5.0 : 2.0);
    result.local_points = local_map_.size();
    result.inliers = optimize();
    if (result.inliers >= o.recovery.min_inliers_recovered && result.inliers >= o.recovery.min_recovered_share * result.local_in_view)
      return is_right_place(map_is_live, true);
    if (result.inliers < kMinPose) return false;
  }
  return false;
}

// Whether what stands round the things that match is there too: all the more after a jump, and while that is tentative.
bool Tracker::is_right_place(bool map_is_live, bool recovered) {
  const bool jump = jumped();
  if (map_is_live && !looks_as_usual(*map_.read(), jump || jumped_at_)) return false;
  if (jump && (recovered || jumped_at_ || !map_is_live)) {
    take_back_jump();
    jumped_at_ = {current_.stamp, current_.index};
  }
  return true;
}

void Tracker::take_back_jump() {
  if (!jumped_at_) return;
  retract_from_ = std::min(jumped_at_->frame, retract_from_.value_or(jumped_at_->frame));
  jumped_at_.reset();
}

// Whether the camera is too far from where it was last to have just moved there.
bool Tracker::jumped() const {
  constexpr double kTurn = 0.966;  // cosine of 15 degrees
  constexpr double kWay = 0.2;     // of the mean depth of what it sees
  if (!last_place_ || local_map_.reference.submap != submap_) return true;
  const SE3 T_cl = current_.T_cw * last_place_->inverse();
  return T_cl.t().norm() > kWay * mean_depth() || (T_cl.R().trace() - 1) / 2 < kTurn;
}

// A few points on one side of the image agree with poses far apart, and wrong matches choose among them.
bool Tracker::well_determined() const {
  constexpr double kSigma = 2;  // pixels: the position's standard deviation, as things at the mean depth show it
  const Matrix6d covariance = information_.inverse();
  return camera_.fx * std::sqrt(covariance.topLeftCorner<3, 3>().trace()) <= kSigma * mean_depth();
}

// Whether the points in view that were seen from about here before are matched about as often as they usually are.
// Where only things like those of the map are seen, they match, but not what stands round them in the map.
bool Tracker::looks_as_usual(const Map& map, bool tentative) {
  constexpr double kEnough = 60;  // usually matched points, for their share to tell
  constexpr uint32_t kKnown = 5;  // frames that had a point in view, for its usual share to be known
  struct Tally {
    double share;  // of as many as usual, asked for
    double usual = 0;
    int found = 0;
  };
  // What was seen from about here decides: 0.6 of it is exceeded by some 98 % of right places and 3 % of wrong ones
  // (docs/results.md). Where that is too little, what was seen from the same side says less, and must not speak against
  // it; more is asked of a single image, which no later ones bear out.
  const double share = (tentative ? 1 : 0.5) * options_.tracker.recovery.min_expected_match_ratio;
  const bool single_image = state_ == TrackState::not_initialised;  // locate()'s: a tracker of its own, never begun
  Tally from_here{share}, from_near{(single_image ? 0.5 : 0.25) * share},
      young_too{(single_image ? 0.25 : 0.17) * share};
  const Eigen::Vector3d centre = current_.T_cw.centre();
  mark_matched();
  for (size_t k = 0; k < local_map_.points.id.size(); ++k) {
    if (!projection_.in_view()[k]) continue;
    const MapPoint* point = map.find(local_map_.points.id[k]);
    if (!point) continue;
    const Eigen::Vector3d ray = point->position_w - centre;
    const double distance = ray.norm();
    bool here = false, near = false;
    for (const Observation& observation : point->observations) {
      const Eigen::Vector3d before = point->position_w - map.at(observation.key_frame).T_cw.centre();
      const double distance_before = before.norm();
      const double cosine = ray.dot(before) / (distance * distance_before);
      const double factor = std::max(distance, distance_before) / std::min(distance, distance_before);
      near = near || (cosine > 0.866 && factor < 2.1);  // 30 degrees
      here = cosine > 0.9962 && factor < 1.44;          // 5 degrees
      if (here) break;
    }
    if (!near) continue;
    const double usual = static_cast<double>(point->found) / point->visible;
    const int found = matched(local_map_.points.id[k]);
    const auto add_to = [&](Tally& tally) {
      tally.usual += usual;
      tally.found += found;
    };
    if (here && point->visible >= kKnown) add_to(from_here);
    if (point->visible >= kKnown) add_to(from_near);
    add_to(young_too);
  }
  const auto enough = [](const Tally& tally) { return tally.usual >= kEnough; };
  const auto passes = [](const Tally& tally) { return tally.found >= tally.share * tally.usual; };
  if (enough(from_here)) return passes(from_here);
  if (enough(from_near) && !passes(from_near)) return false;
  if (enough(young_too)) return passes(young_too);
  return !tentative || share == 0;  // seen from where nothing was seen from before
}

}  // namespace covis
