// SPDX-License-Identifier: Apache-2.0
#include "covis/slam/global_adjuster.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "covis/core/log.h"
#include "covis/core/time.h"
#include "covis/optimization/focal_estimation.h"

namespace covis {

void GlobalAdjuster::start(const SharedMap& shared, KeyFrameId of_part, int iterations) {
  abandon();
  given_fx_ = 0;
  begin(shared, of_part, iterations);
}

void GlobalAdjuster::start_focal(const SharedMap& shared, KeyFrameId of_part, double given_fx) {
  constexpr int kIterations = 20;
  abandon();
  given_fx_ = given_fx;
  begin(shared, of_part, kIterations);
}

void GlobalAdjuster::begin(const SharedMap& shared, KeyFrameId of_part, int iterations) {
  camera_.reset();
  problem_ = {};
  {
    const auto map = shared.read();
    const std::vector<KeyFrameId> frames = map->key_frames(map->at(of_part).part);
    if (frames.size() < 2) return;
    problem_.gather(*map, frames, frames.size());
  }
  interrupt_ = done_ = false;
  thread_ = std::thread([this, iterations] { adjust(iterations); });
}

void GlobalAdjuster::adjust(int iterations) {
  const Stopwatch watch;
  BundleAdjuster adjuster;
  summary_ = adjuster.solve(problem_.problem, {.iterations = iterations, .interrupt = &interrupt_});
  classify_observations(problem_.problem);
  if (given_fx_ > 0 && summary_.ok && refine_focal(adjuster)) camera_ = problem_.problem.camera;
  ms_ = watch.ms();
  done_ = true;
}

// Moves the problem to its best focal length when that is known well, and surely another one.
bool GlobalAdjuster::refine_focal(BundleAdjuster& adjuster) {
  constexpr double kMaxSigma = 0.005, kSignificant = 4, kMinChange = 0.006, kMaxChange = 0.05;
  BundleProblem& problem = problem_.problem;
  const FocalEstimate estimate = estimate_focal(problem, adjuster, &interrupt_);
  if (!estimate.ok || estimate.sigma > kMaxSigma) return false;
  if (std::abs(estimate.factor - 1) < std::max(kMinChange, kSignificant * estimate.sigma)) return false;
  const Pinhole refined = with_focal(problem.camera, estimate.factor);
  if (std::abs(refined.fx / given_fx_ - 1) > kMaxChange) return false;
  problem.camera = refined;
  summary_ = adjuster.solve(problem, {.iterations = 20, .interrupt = &interrupt_});
  classify_observations(problem);
  return summary_.ok && !summary_.interrupted;
}

void GlobalAdjuster::abandon() {
  if (!thread_.joinable()) return;
  interrupt_ = true;
  thread_.join();
}

double GlobalAdjuster::commit(SharedMap& map) {
  thread_.join();
  if (given_fx_ > 0) {
    const auto locked = map.write();
    if (locked->parts().size() > 1) camera_.reset();  // begun meanwhile: the others were not adjusted to it
    if (camera_) {
      locked->set_camera(*camera_);
      take_over(*locked);
      log(LogLevel::info, "focal length refined: " + std::to_string(camera_->fx) + " pixels instead of " +
                              std::to_string(given_fx_));
    }
  } else if (summary_.ok) {
    take_over(*map.write());
  } else {
    log(LogLevel::warning, "the full bundle adjustment after a loop failed; the map stays as it was");
  }
  problem_ = {};
  return ms_;
}

void GlobalAdjuster::take_over(Map& map) const {
  const auto& frames = problem_.key_frames;
  const auto alive = std::find_if(frames.begin(), frames.end(), [&](KeyFrameId id) { return map.find(id); });
  if (alive == frames.end()) return;  // the part was given up
  const MapPart part = *map.part(map.at(*alive).part);
  std::vector<SE3> before, after;    // by slot
  std::vector<uint8_t> adjusted;     // by slot: has an adjusted pose
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
  std::vector<KeyFrameId> open{part.root};
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
    if (map.at(point.reference).part != part.number) return;
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
}

}  // namespace covis
