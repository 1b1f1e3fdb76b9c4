// SPDX-License-Identifier: Apache-2.0
#include "covis/mapping/initial_map.h"

#include <algorithm>
#include <memory>
#include <utility>
#include <vector>

#include "covis/core/log.h"
#include "covis/core/quantile.h"
#include "covis/features/straightening.h"
#include "covis/map/map_edit.h"

namespace covis {
namespace {

// Two poses, the first of which stays, and all points. Pose and point k are those of the request.
BundleProblem problem_of(const InitialMapRequest& request, const Pinhole& camera, const Features& first,
                         const Features& second) {
  BundleProblem problem;
  problem.camera = camera;
  problem.poses = {SE3(), request.T_21};
  problem.fixed = {1, 0};
  for (size_t p = 0; p < request.points.size(); ++p) {
    const InitialMapRequest::Point& point = request.points[p];
    problem.points.push_back(point.position_w);
    const auto add = [&](int32_t pose, const Features& f, uint32_t i) {
      problem.observations.push_back({.pose = pose,
                                      .point = static_cast<int32_t>(p),
                                      .u = f.x[i],
                                      .v = f.y[i],
                                      .inv_sigma2 = f.pyramid->inv_sigma2[f.level[i]],
                                      .disparity = {}});
    };
    add(0, first, point.feature_first);
    add(1, second, point.feature_second);
  }
  return problem;
}

// The factor that brings the median depth of the good points to 1.
std::optional<double> unit_scale(const BundleProblem& problem, const std::vector<uint8_t>& good) {
  constexpr int kMinPoints = 100;
  const int least = std::min(kMinPoints, static_cast<int>(problem.points.size()));
  std::vector<double> depths;
  for (size_t p = 0; p < good.size(); ++p) {
    if (good[p]) depths.push_back(problem.points[p].z());
  }
  if (depths.empty() || static_cast<int>(depths.size()) < least) {
    log(LogLevel::info, "initial map given up: too few points survive adjustment");
    return std::nullopt;
  }
  const double median = quantile(std::move(depths), 0.5);
  if (median > 0) return 1 / median;
  log(LogLevel::info, "initial map given up: its median depth is negative");
  return std::nullopt;
}

}  // namespace

std::optional<InitialMap> make_initial_map(SharedMap& shared, const InitialMapRequest& request,
                                           BundleAdjuster& adjuster, RecentPoints& recent) {
  constexpr int kIterations = 20;
  const Pinhole camera = shared.read()->camera();
  const Eigen::Vector3d kUnknownTurn = Eigen::Vector3d::Zero();
  const FeaturesPtr first = key_frame_features(*request.first.features, nullptr, kUnknownTurn, camera);
  const FeaturesPtr second = key_frame_features(*request.second.features, nullptr, kUnknownTurn, camera);
  BundleProblem problem = problem_of(request, camera, *first, *second);
  adjuster.solve(problem, {.iterations = kIterations});
  classify_observations(problem);
  std::vector<uint8_t> good(problem.points.size(), 1);  // no observation is an outlier
  for (const BundleObservation& observation : problem.observations) {
    if (!observation.active) good[static_cast<size_t>(observation.point)] = 0;
  }
  const std::optional<double> scale = unit_scale(problem, good);
  if (!scale) return std::nullopt;

  MapEdit map(shared);
  const SE3 T_21(problem.poses[1].R(), Eigen::Vector3d(problem.poses[1].t() * *scale));
  InitialMap made;
  made.first = map.map().begin_submap(request.first.frame, request.first.stamp, SE3(), first);
  const uint32_t submap = map->at(made.first).submap;
  made.second = map.map().add_key_frame(request.second.frame, request.second.stamp, T_21, second, submap);
  if (!made.second.valid()) {
    map.map().erase_submap(submap);
    return std::nullopt;
  }
  for (size_t p = 0; p < good.size(); ++p) {
    if (!good[p]) continue;
    const MapPointId id = map.add_point(problem.points[p] * *scale, made.first, request.points[p].feature_first);
    if (!id.valid()) continue;
    map.add_observation(id, made.second, request.points[p].feature_second);
    recent.add(id, map->at(made.second).serial);
    ++made.points;
  }
  map.map().attach_to_tree(made.second);
  return made;
}

}  // namespace covis
