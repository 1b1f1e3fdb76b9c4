// SPDX-License-Identifier: Apache-2.0
#include "covis/mapping/map_problem.h"

#include <algorithm>
#include <span>
#include <utility>

#include "covis/matching/point_geometry.h"
#include "covis/matching/point_set.h"

namespace covis {

void MapProblem::gather(const Map& map, const std::vector<KeyFrameId>& frames, size_t moving) {
  key_frames = frames;
  problem.camera = map.camera();
  std::vector<std::pair<KeyFrameId, int32_t>> pose_of;  // sorted by handle
  for (size_t k = 0; k < frames.size(); ++k) {
    problem.poses.push_back(map.at(frames[k]).T_cw);
    problem.fixed.push_back(k >= moving || map.is_root(frames[k]));
    pose_of.emplace_back(frames[k], static_cast<int32_t>(k));
  }
  std::sort(pose_of.begin(), pose_of.end());
  points = points_of(map, std::span(frames).first(moving));
  problem.points.reserve(points.size());
  for (size_t p = 0; p < points.size(); ++p) {
    const MapPoint& point = map.at(points[p]);
    problem.points.push_back(point.position_w);
    auto next = pose_of.begin();  // observations are sorted by handle too
    for (const Observation& seen : point.observations) {
      next = std::lower_bound(next, pose_of.end(), std::pair{seen.key_frame, int32_t{-1}});
      if (next == pose_of.end()) break;
      if (next->first != seen.key_frame) continue;
      const Features& features = *map.at(seen.key_frame).features;
      const uint32_t i = seen.feature;
      problem.observations.push_back({.pose = next->second,
                                      .point = static_cast<int32_t>(p),
                                      .u = features.x[i],
                                      .v = features.y[i],
                                      .inv_sigma2 = features.pyramid->inv_sigma2[features.level[i]],
                                      .disparity = disparity_of(features, i, map.camera())});
    }
  }
}

void MapProblem::commit(MapEdit& map) const {
  for (size_t k = 0; k < key_frames.size(); ++k) {
    if (!problem.fixed[k]) map.map().set_pose(key_frames[k], problem.poses[k].normalized());
  }
  for (size_t p = 0; p < points.size(); ++p) map.set_position(points[p], problem.points[p]);
  erase_outliers(map);
}

void MapProblem::erase_outliers(MapEdit& map) const {
  for (const BundleObservation& observation : problem.observations) {
    if (observation.active) continue;
    map.erase_observation(points[static_cast<size_t>(observation.point)],
                          key_frames[static_cast<size_t>(observation.pose)]);
  }
}

}  // namespace covis
