// SPDX-License-Identifier: Apache-2.0
#include "covis/loops/submap_adjustment.h"

#include <algorithm>
#include <unordered_map>
#include <utility>
#include <vector>

#include "covis/features/straightening.h"
#include "covis/map/map_edit.h"
#include "covis/mapping/local_adjustment.h"
#include "covis/matching/point_geometry.h"
#include "covis/optimization/pose_optimization.h"

namespace covis {
namespace {

// Poses of key frames by slot.
struct Poses {
  std::vector<SE3> before, after;
  std::vector<uint8_t> adjusted;  // the pose was part of the problem
  std::vector<double> growth;     // factor by which lengths around the key frame grew

  Poses(const Map& map, const MapProblem& problem) {
    map.for_each_key_frame([&](KeyFrameId id, const KeyFrame& key_frame) {
      before.resize(id.slot + size_t{1});
      before[id.slot] = key_frame.T_cw;
    });
    after = before;
    adjusted.resize(before.size(), 0);
    growth.resize(before.size(), 1);
    for (size_t k = 0; k < problem.key_frames.size(); ++k) {
      const KeyFrameId id = problem.key_frames[k];
      if (!map.find(id)) continue;
      after[id.slot] = problem.problem.poses[k].normalized();
      adjusted[id.slot] = 1;
    }
  }

  // By the steps to the two adjusted key frames before and the two after, in the order of time.
  void measure_growth(const Map& map, const MapProblem& problem) {
    constexpr size_t kBeside = 2;
    constexpr double kMost = 2;  // a step that was nothing before says nothing
    std::vector<uint32_t> slots;
    for (const KeyFrameId& id : problem.key_frames)
      if (map.find(id)) slots.push_back(id.slot);
    const auto step = [](const std::vector<SE3>& of, uint32_t a, uint32_t b) {
      return (of[a].centre() - of[b].centre()).norm();
    };
    for (size_t k = 0; k < slots.size(); ++k) {
      double old_length = 0, new_length = 0;
      const size_t first = k < kBeside ? 0 : k - kBeside, last = std::min(k + kBeside, slots.size() - 1);
      for (size_t j = first; j < last; ++j) {
        old_length += step(before, slots[j], slots[j + 1]);
        new_length += step(after, slots[j], slots[j + 1]);
      }
      if (old_length > 0 && new_length > 0) growth[slots[k]] = std::clamp(new_length / old_length, 1 / kMost, kMost);
    }
  }

  // Brings a pose relative to a key frame to the lengths around it now.
  SE3 grown(const SE3& T_cr, uint32_t reference) const {
    return SE3(T_cr.R(), Eigen::Vector3d(growth[reference] * T_cr.t()));
  }
};

// The camera that the map is to have, and the keypoints that key frames get with it where theirs are not free of its
// residual distortion.
struct NewCamera {
  Pinhole camera;
  std::unordered_map<KeyFrameId, FeaturesPtr> straight;

  NewCamera(const Map& map, const Pinhole& now) : camera(now) {
    map.for_each_key_frame([&](KeyFrameId id, const KeyFrame& key_frame) {
      const Features& features = *key_frame.features;
      if (!straight_for(features, camera)) straight.emplace(id, straightened(features, camera));
    });
  }
  const Features& features(const Map& map, KeyFrameId id) const {
    const auto found = straight.find(id);
    return found == straight.end() ? *map.at(id).features : *found->second;
  }
};

// The new places of a submap's key frames and points.
struct SubmapPlaces {
  std::vector<KeyFrameMove> key_frames;
  std::vector<KeyFrameId> newer;  // those among them that are newer than the copy
  std::vector<std::pair<MapPointId, Eigen::Vector3d>> points;
};

// Works them out. Key frames and points that are newer than the copy keep their places beside their parents and
// references, in the lengths there; where lengths changed, these key frames are then put where the adjusted points show
// them, and these points on the rays of their references.
class Carrier {
 public:
  Carrier(const Map& map, const MapProblem& adjusted, const NewCamera* changed)
      : map_(map), adjusted_(adjusted), changed_(changed), poses_(map, adjusted) {
    if (changed_) poses_.measure_growth(map, adjusted);
  }

  SubmapPlaces carry(const Submap& submap) {
    SubmapPlaces places;
    for (const KeyFrameId& id : carry_down(submap.root)) {
      const KeyFrame& key_frame = map_.at(id);
      places.key_frames.push_back({id, key_frame.frame, key_frame.T_cw, poses_.after[id.slot], key_frame.scale,
                                   poses_.growth[id.slot] * key_frame.scale});
      if (!poses_.adjusted[id.slot]) places.newer.push_back(id);
    }
    map_.for_each_point([&](MapPointId id, const MapPoint& point) {
      if (map_.at(point.reference).submap != submap.id) return;
      const Eigen::Vector3d* const adjusted = adjusted_point(id);
      places.points.emplace_back(id, adjusted ? *adjusted : carried(point));
    });
    return places;
  }

 private:
  // The key frames of a submap from its root down.
  std::vector<KeyFrameId> carry_down(KeyFrameId root) {
    std::vector<KeyFrameId> open{root};
    for (size_t k = 0; k < open.size(); ++k) {
      const KeyFrameId id = open[k];
      const KeyFrame& key_frame = map_.at(id);
      if (!poses_.adjusted[id.slot] && key_frame.parent.valid()) {
        const uint32_t parent = key_frame.parent.slot;
        const SE3 T_cp = poses_.grown(key_frame.T_cw * poses_.before[parent].inverse(), parent);
        const SE3 T_cw = (T_cp * poses_.after[parent]).normalized();
        poses_.after[id.slot] = changed_ ? seen(id, T_cw) : T_cw;
        poses_.growth[id.slot] = poses_.growth[parent];
      }
      open.insert(open.end(), key_frame.children.begin(), key_frame.children.end());
    }
    return open;
  }

  // The pose that the adjusted points show; the given one where these are few.
  SE3 seen(KeyFrameId id, const SE3& T_cw) const {
    constexpr int kLeastInliers = 30;
    const KeyFrame& key_frame = map_.at(id);
    const Features& features = changed_->features(map_, id);
    PoseObservations observations;
    for (uint32_t i = 0; i < key_frame.points.size(); ++i) {
      const MapPointId point = key_frame.points[i];
      const Eigen::Vector3d* const at = point.valid() ? adjusted_point(point) : nullptr;
      if (at)
        observations.add(*at, features.x[i], features.y[i], features.pyramid->inv_sigma2[features.level[i]],
                         disparity_of(features, i, changed_->camera));
    }
    std::vector<uint8_t> inlier;
    const PoseResult pose = optimize_pose(T_cw, observations, changed_->camera, {}, inlier);
    return pose.ok && pose.inliers >= kLeastInliers ? pose.T_cw.normalized() : T_cw;
  }

  Eigen::Vector3d carried(const MapPoint& point) const {
    const uint32_t reference = point.reference.slot;
    Eigen::Vector3d p_r = poses_.growth[reference] * (poses_.before[reference] * point.position_w);
    if (changed_) {
      const Features& features = changed_->features(map_, point.reference);
      const int feature = point.feature_in(point.reference);
      p_r = p_r.z() * changed_->camera.unproject(features.x[feature], features.y[feature]);
    }
    return poses_.after[reference].inverse() * p_r;
  }

  const Eigen::Vector3d* adjusted_point(MapPointId id) const {
    const auto at = std::lower_bound(adjusted_.points.begin(), adjusted_.points.end(), id);
    if (at == adjusted_.points.end() || *at != id) return nullptr;
    return &adjusted_.problem.points[static_cast<size_t>(at - adjusted_.points.begin())];
  }

  const Map& map_;
  const MapProblem& adjusted_;
  const NewCamera* const changed_;  // null: lengths are what they were
  Poses poses_;
};

// Returns Map::moves() from then on.
uint64_t write(const MapProblem& adjusted, const SubmapPlaces& places, const NewCamera* camera, SharedMap& shared) {
  MapEdit map(shared);  // all of it at once: poses, points and camera belong together
  map.map().count_move();
  for (const KeyFrameMove& move : places.key_frames)
    map.map().correct_pose(move.key_frame, move.after, move.scale_after / move.scale_before);
  for (const auto& [id, position] : places.points) map.set_position(id, position);
  adjusted.erase_outliers(map);
  if (camera) {
    for (const auto& [id, features] : camera->straight) map.map().set_features(id, features);
    map.map().set_camera(camera->camera);
  }
  return map->moves();
}

// Key frames that are newer than the copy were mapped with another camera, and so were their points: they are adjusted
// to what the copy gave.
void settle(SharedMap& shared, const std::vector<KeyFrameId>& newer) {
  constexpr int kHolders = 40, kIterations = 10;
  MapProblem local;
  {
    const auto map = shared.read();
    const LocalWindow window = window_around(*map, newer, kHolders);
    if (window.key_frames.size() == newer.size()) return;
    local.gather(*map, window.key_frames, window.moving);
  }
  BundleAdjuster adjuster;
  for (const bool robust : {true, false}) {
    if (!adjuster.solve(local.problem, {.iterations = kIterations, .robust = robust}).ok) return;
    classify_observations(local.problem);
  }
  MapEdit map(shared);
  local.commit(map);
}

}  // namespace

std::optional<MapProblem> copy_submap(const Map& map, KeyFrameId key_frame) {
  const std::vector<KeyFrameId> frames = map.key_frames(map.at(key_frame).submap);
  if (frames.size() < 2) return std::nullopt;
  MapProblem problem;
  problem.gather(map, frames, frames.size());
  return problem;
}

std::optional<KeyFrameMoves> apply_submap(const MapProblem& adjusted, SharedMap& shared,
                                          const std::optional<Pinhole>& camera, Lengths lengths) {
  const auto& frames = adjusted.key_frames;
  std::optional<NewCamera> made;
  SubmapPlaces places;
  {
    const auto map = shared.read();
    const auto alive = std::find_if(frames.begin(), frames.end(), [&](KeyFrameId id) { return map->find(id); });
    if (alive == frames.end()) return std::nullopt;
    if (camera) made.emplace(*map, *camera);
    Carrier carrier(*map, adjusted, made && lengths == Lengths::changed ? &*made : nullptr);
    places = carrier.carry(*map->submap(map->at(*alive).submap));
  }
  KeyFrameMoves moves{.of = {}, .moves = write(adjusted, places, made ? &*made : nullptr, shared)};
  if (lengths == Lengths::kept) return moves;
  if (!places.newer.empty()) settle(shared, places.newer);
  moves.of = std::move(places.key_frames);
  const auto map = shared.read();
  for (KeyFrameMove& move : moves.of) move.after = map->at(move.key_frame).T_cw;
  return moves;
}

std::unique_ptr<FullAdjustment> FullAdjustment::of(const Map& map, KeyFrameId key_frame, int iterations) {
  std::optional<MapProblem> submap = copy_submap(map, key_frame);
  if (!submap) return nullptr;
  return std::unique_ptr<FullAdjustment>(new FullAdjustment(std::move(*submap), iterations));
}

bool FullAdjustment::run(const std::atomic<bool>& interrupt) {
  BundleAdjuster adjuster;
  const bool solved = adjuster.solve(submap_.problem, {.iterations = iterations_, .interrupt = &interrupt}).ok;
  classify_observations(submap_.problem);
  return solved;
}

}  // namespace covis
