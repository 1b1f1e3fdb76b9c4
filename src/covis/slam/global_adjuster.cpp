// SPDX-License-Identifier: Apache-2.0
#include "covis/slam/global_adjuster.h"

#include <algorithm>
#include <string>
#include <vector>

#include "covis/core/log.h"
#include "covis/core/time.h"
#include "covis/slam/focal_refinement.h"

namespace covis {

void GlobalAdjuster::start(const SharedMap& shared, KeyFrameId of_submap, int iterations,
                           std::optional<double> given_fx) {
  abandon();
  given_fx_ = given_fx;
  good_ = false;
  problem_ = {};
  {
    const auto map = shared.read();
    const std::vector<KeyFrameId> frames = map->key_frames(map->at(of_submap).submap);
    if (frames.size() < 2) return;
    problem_.gather(*map, frames, frames.size());
  }
  interrupt_ = done_ = false;
  thread_ = std::thread([this, iterations] { adjust(iterations); });
}

void GlobalAdjuster::adjust(int iterations) {
  const Stopwatch watch;
  BundleAdjuster adjuster;
  BundleProblem& problem = problem_.problem;
  good_ = adjuster.solve(problem, {.iterations = iterations, .interrupt = &interrupt_}).ok;
  classify_observations(problem);
  if (given_fx_) good_ = good_ && refine_focal(problem, adjuster, *given_fx_, &interrupt_);
  ms_ = watch.ms();
  done_ = true;
}

void GlobalAdjuster::abandon() {
  if (!thread_.joinable()) return;
  interrupt_ = true;
  thread_.join();
}

GlobalAdjuster::Outcome GlobalAdjuster::commit(SharedMap& shared) {
  thread_.join();
  Outcome outcome{.focal = given_fx_.has_value(), .ms = ms_};
  if (good_) {
    const auto map = shared.write();
    // A submap begun meanwhile was not adjusted to another camera.
    outcome.taken_over = (!outcome.focal || map->submaps().size() == 1) && take_over(*map);
  } else if (!outcome.focal) {
    log(LogLevel::warning, "the full bundle adjustment after a loop failed; the map stays as it was");
  }
  if (outcome.focal && outcome.taken_over) {
    log(LogLevel::info, "focal length refined: " + std::to_string(problem_.problem.camera.fx) + " pixels instead of " +
                            std::to_string(*given_fx_));
  }
  problem_ = {};
  return outcome;
}

// False when the submap was given up meanwhile.
bool GlobalAdjuster::take_over(Map& map) const {
  const auto& frames = problem_.key_frames;
  const auto alive = std::find_if(frames.begin(), frames.end(), [&](KeyFrameId id) { return map.find(id); });
  if (alive == frames.end()) return false;
  if (given_fx_) map.set_camera(problem_.problem.camera);
  map.count_move();
  const Submap submap = *map.submap(map.at(*alive).submap);
  std::vector<SE3> before, after;  // by slot
  std::vector<uint8_t> adjusted;   // by slot: has an adjusted pose
  const auto room = [&](KeyFrameId id) {
    if (id.slot < before.size()) return;
    before.resize(id.slot + size_t{1});
    after.resize(before.size());
    adjusted.resize(before.size(), 0);
  };
  map.for_each_key_frame([&](KeyFrameId id, const KeyFrame& key_frame) {
    room(id);
    before[id.slot] = after[id.slot] = key_frame.T_cw;
  });
  for (size_t k = 0; k < problem_.key_frames.size(); ++k) {
    const KeyFrameId id = problem_.key_frames[k];
    if (!map.find(id)) continue;
    after[id.slot] = problem_.problem.poses[k].normalized();
    adjusted[id.slot] = 1;
  }
  // From the root down: what is newer than the copy keeps its place beside its parent.
  std::vector<KeyFrameId> open{submap.root};
  for (size_t k = 0; k < open.size(); ++k) {
    const KeyFrame& key_frame = map.at(open[k]);
    if (!adjusted[open[k].slot] && key_frame.parent.valid()) {
      const uint32_t parent = key_frame.parent.slot;
      after[open[k].slot] = (key_frame.T_cw * before[parent].inverse() * after[parent]).normalized();
    }
    open.insert(open.end(), key_frame.children.begin(), key_frame.children.end());
  }
  std::vector<std::pair<MapPointId, Eigen::Vector3d>> places;
  map.for_each_point([&](MapPointId id, const MapPoint& point) {
    if (map.at(point.reference).submap != submap.id) return;
    const auto at = std::lower_bound(problem_.points.begin(), problem_.points.end(), id);
    if (at != problem_.points.end() && *at == id) {
      places.emplace_back(id, problem_.problem.points[static_cast<size_t>(at - problem_.points.begin())]);
    } else {
      const uint32_t reference = point.reference.slot;
      places.emplace_back(id, after[reference].inverse() * (before[reference] * point.position_w));
    }
  });
  for (const KeyFrameId& id : open) map.set_pose(id, after[id.slot]);
  for (const auto& [id, position] : places) map.set_position(id, position);
  for (const BundleObservation& observation : problem_.problem.observations) {
    if (!observation.active) {
      map.erase_observation(problem_.points[static_cast<size_t>(observation.point)],
                            problem_.key_frames[static_cast<size_t>(observation.pose)]);
    }
  }
  for (const auto& [id, position] : places) {
    if (map.find(id)) map.refresh_point_geometry(id);
  }
  return true;
}

}  // namespace covis
