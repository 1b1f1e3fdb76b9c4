// SPDX-License-Identifier: Apache-2.0
#include "covis/mapping/map_problem.h"

#include <algorithm>
#include <span>
#include <utility>

#include "covis/map/anchors.h"
#include "covis/matching/patch_alignment.h"
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
  const float closer = aligned_weight(problem.camera);
  for (size_t p = 0; p < points.size(); ++p) {
    const MapPoint& point = map.at(points[p]);
    problem.points.push_back(point.position_w);
    const AlignedObservations aligned_ones(map, point);
    auto next = pose_of.begin();  // observations are sorted by handle too
    for (const Observation& seen : point.observations) {
      next = std::lower_bound(next, pose_of.end(), std::pair{seen.key_frame, int32_t{-1}});
      if (next == pose_of.end()) break;
      if (next->first != seen.key_frame) continue;
      const KeyFrame& key_frame = map.at(seen.key_frame);
      const Features& features = *key_frame.features;
      const uint32_t i = seen.feature;
      aligned.push_back(aligned_ones.contain(key_frame, i));
      const float weight = aligned.back() ? closer : 1;
      problem.observations.push_back({.pose = next->second,
                                      .point = static_cast<int32_t>(p),
                                      .u = features.x[i],
                                      .v = features.y[i],
                                      .inv_sigma2 = weight * features.pyramid->inv_sigma2[features.level[i]],
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

bool MapProblem::fits_as_keypoint(size_t k) const {
  BundleObservation o = problem.observations[k];
  if (!aligned[k]) return false;
  o.inv_sigma2 /= aligned_weight(problem.camera);
  const Eigen::Vector3d p_c = problem.poses[static_cast<size_t>(o.pose)] * problem.points[static_cast<size_t>(o.point)];
  if (!(p_c.z() > kMinDepth)) return false;
  const Eigen::Vector3d residual = reprojection_residual(p_c, problem.camera, o.u, o.v, o.disparity);
  return within_bound(Chi2(residual, o.inv_sigma2, o.disparity), problem.camera, o.disparity);
}

void MapProblem::erase_outliers(MapEdit& map) const {
  for (size_t k = 0; k < problem.observations.size(); ++k) {
    const BundleObservation& observation = problem.observations[k];
    if (observation.active || fits_as_keypoint(k)) continue;
    map.erase_observation(points[static_cast<size_t>(observation.point)],
                          key_frames[static_cast<size_t>(observation.pose)]);
  }
}

}  // namespace covis
