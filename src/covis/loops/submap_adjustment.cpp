// SPDX-License-Identifier: Apache-2.0
#include "covis/loops/submap_adjustment.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "covis/features/straightening.h"
#include "covis/map/map_edit.h"

namespace covis {
namespace {

// Poses of key frames by slot.
struct Poses {
  std::vector<SE3> before, after;
  std::vector<uint8_t> adjusted;  // the pose was part of the problem

  Poses(const Map& map, const MapProblem& problem) {
    map.for_each_key_frame([&](KeyFrameId id, const KeyFrame& key_frame) {
      before.resize(id.slot + size_t{1});
      before[id.slot] = key_frame.T_cw;
    });
    after = before;
    adjusted.resize(before.size(), 0);
    for (size_t k = 0; k < problem.key_frames.size(); ++k) {
      const KeyFrameId id = problem.key_frames[k];
      if (!map.find(id)) continue;
      after[id.slot] = problem.problem.poses[k].normalized();
      adjusted[id.slot] = 1;
    }
  }
};

// The key frames of a submap from its root down. Those that are newer than the copy keep their places beside their
// parents.
std::vector<KeyFrameId> carry_down(const Map& map, KeyFrameId root, Poses& poses) {
  std::vector<KeyFrameId> open{root};
  for (size_t k = 0; k < open.size(); ++k) {
    const KeyFrame& key_frame = map.at(open[k]);
    if (!poses.adjusted[open[k].slot] && key_frame.parent.valid()) {
      const uint32_t parent = key_frame.parent.slot;
      poses.after[open[k].slot] = (key_frame.T_cw * poses.before[parent].inverse() * poses.after[parent]).normalized();
    }
    open.insert(open.end(), key_frame.children.begin(), key_frame.children.end());
  }
  return open;
}

// The new places of a submap's key frames and points.
struct SubmapPlaces {
  std::vector<KeyFrameMove> key_frames;
  std::vector<std::pair<MapPointId, Eigen::Vector3d>> points;
};

std::optional<SubmapPlaces> places_of(const Map& map, const MapProblem& adjusted) {
  const auto& frames = adjusted.key_frames;
  const auto alive = std::find_if(frames.begin(), frames.end(), [&](KeyFrameId id) { return map.find(id); });
  if (alive == frames.end()) return std::nullopt;
  const Submap& submap = *map.submap(map.at(*alive).submap);
  Poses poses(map, adjusted);
  SubmapPlaces places;
  for (const KeyFrameId& id : carry_down(map, submap.root, poses)) {
    const KeyFrame& key_frame = map.at(id);
    places.key_frames.push_back({id, key_frame.frame, key_frame.scale, key_frame.T_cw, poses.after[id.slot]});
  }
  map.for_each_point([&](MapPointId id, const MapPoint& point) {
    if (map.at(point.reference).submap != submap.id) return;
    const auto at = std::lower_bound(adjusted.points.begin(), adjusted.points.end(), id);
    if (at != adjusted.points.end() && *at == id) {
      places.points.emplace_back(id, adjusted.problem.points[static_cast<size_t>(at - adjusted.points.begin())]);
    } else {
      const uint32_t reference = point.reference.slot;
      places.points.emplace_back(id, poses.after[reference].inverse() * (poses.before[reference] * point.position_w));
    }
  });
  return places;
}

using StraightFeatures = std::vector<std::pair<KeyFrameId, FeaturesPtr>>;

// The keypoints of key frames whose present ones are not free of this camera's residual distortion.
StraightFeatures straight_features(const Map& map, const Pinhole& camera) {
  StraightFeatures made;
  map.for_each_key_frame([&](KeyFrameId id, const KeyFrame& key_frame) {
    const Features& features = *key_frame.features;
    if (!straight_for(features, camera)) made.emplace_back(id, straightened(features, camera));
  });
  return made;
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
                                          const std::optional<Pinhole>& camera) {
  std::optional<SubmapPlaces> places = places_of(*shared.read(), adjusted);
  if (!places) return std::nullopt;
  const auto straight = camera ? straight_features(*shared.read(), *camera) : StraightFeatures();
  MapEdit map(shared);  // all of it at once: poses, points and camera belong together
  map.map().count_move();
  for (const KeyFrameMove& move : places->key_frames) map.map().set_pose(move.key_frame, move.after);
  for (const auto& [id, position] : places->points) map.set_position(id, position);
  adjusted.erase_outliers(map);
  for (const auto& [id, features] : straight) map.map().set_features(id, features);
  if (camera) map.map().set_camera(*camera);
  return KeyFrameMoves{std::move(places->key_frames), map->moves()};
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

// Frames stay beside their references: following the key frames on both sides gained nothing (note 60).
std::optional<KeyFrameMoves> FullAdjustment::apply(SharedMap& map) const {
  std::optional<KeyFrameMoves> moves = apply_submap(submap_, map);
  if (moves) moves->of.clear();
  return moves;
}

}  // namespace covis
