// SPDX-License-Identifier: Apache-2.0
// Bundle adjustment on copies of the map: local, full, and of a monocular map's first two views.
// Source: ORB-SLAM, T-RO 2015, sections IV (step 5) and VI-D; ORB-SLAM2, T-RO 2017, section III-C.
#include <algorithm>

#include "covis/core/log.h"
#include "covis/slam/map_problem.h"
#include "covis/slam/mapper.h"
#include "covis/matching/point_geometry.h"

namespace covis {

void Mapper::local_bundle_adjustment(KeyFrameId current, const std::atomic<bool>* interrupt, MappingReport& report) {
  MapProblem local;
  {
    const auto map = map_.read();
    std::vector<KeyFrameId> frames{current};
    for (const Neighbour& n : map->best_neighbours(current, options_.mapper.ba_key_frames - 1))
      frames.push_back(n.key_frame);
    const size_t moving = frames.size();

    // The others that see the moving ones' points, those that share most first.
    std::vector<Neighbour> holders;
    for (size_t k = 0; k < moving; ++k) {
      for (const Neighbour& n : map->at(frames[k]).shared) {
        if (std::find(frames.begin(), frames.begin() + static_cast<ptrdiff_t>(moving), n.key_frame) ==
            frames.begin() + static_cast<ptrdiff_t>(moving)) {
          holders.push_back(n);
        }
      }
    }
    std::sort(holders.begin(), holders.end(),
              [](const Neighbour& x, const Neighbour& y) { return x.key_frame < y.key_frame; });
    std::vector<Neighbour> summed;
    for (const Neighbour& n : holders) {
      if (!summed.empty() && summed.back().key_frame == n.key_frame) {
        summed.back().weight += n.weight;
      } else {
        summed.push_back(n);
      }
    }
    std::stable_sort(summed.begin(), summed.end(),
                     [](const Neighbour& x, const Neighbour& y) { return x.weight > y.weight; });
    if (summed.size() > static_cast<size_t>(options_.mapper.ba_fixed_key_frames)) {
      summed.resize(static_cast<size_t>(options_.mapper.ba_fixed_key_frames));
    }
    for (const Neighbour& n : summed) frames.push_back(n.key_frame);
    local.gather(*map, frames, moving);
    report.ba_key_frames = static_cast<int>(moving);
    report.ba_points = static_cast<int>(local.points.size());
    report.ba_observations = static_cast<int>(local.problem.observations.size());
  }
  // Without anything to hold it the window would drift as a whole: its oldest key frame stays.
  BundleProblem& problem = local.problem;
  if (std::find(problem.fixed.begin(), problem.fixed.end(), 1) == problem.fixed.end()) problem.fixed.back() = 1;

  BundleSummary summary =
      adjuster_.solve(problem, {.iterations = options_.mapper.ba_iterations_first, .interrupt = interrupt});
  if (summary.ok && !summary.interrupted && options_.mapper.ba_iterations_second > 0) {
    classify_observations(problem);
    summary = adjuster_.solve(
        problem, {.iterations = options_.mapper.ba_iterations_second, .robust = false, .interrupt = interrupt});
  }
  report.ba_interrupted = summary.interrupted;
  if (!summary.ok) return;
  classify_observations(problem);
  local.commit(*map_.write());
}

MappingReport Mapper::initialise(const InitialMapRequest& request) {
  constexpr int kIterations = 20;
  constexpr int kMinPoints = 100;
  const int least_points = std::min(kMinPoints, static_cast<int>(request.points.size()));
  MappingReport report;
  report.frame = request.second.frame;
  BundleProblem problem;
  problem.camera = map_.read()->camera();
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
                                      .inv_sigma2 = f.pyramid->inv_sigma2[f.level[i]]});
    };
    add(0, *request.first.features, point.feature_first);
    add(1, *request.second.features, point.feature_second);
  }
  adjuster_.solve(problem, {.iterations = kIterations});
  classify_observations(problem);

  std::vector<uint8_t> good(problem.points.size(), 1);
  for (const BundleObservation& observation : problem.observations) {
    if (!observation.active) good[static_cast<size_t>(observation.point)] = 0;
  }
  std::vector<double> depths;
  for (size_t p = 0; p < good.size(); ++p) {
    if (good[p]) depths.push_back(problem.points[p].z());
  }
  if (static_cast<int>(depths.size()) < least_points) {
    log(LogLevel::info, "initial map given up: too few points survive adjustment");
    return report;
  }
  const auto middle = depths.begin() + static_cast<ptrdiff_t>(depths.size() / 2);
  std::nth_element(depths.begin(), middle, depths.end());
  if (!(*middle > 0)) {
    log(LogLevel::info, "initial map given up: its median depth is negative");
    return report;
  }
  const double scale = 1 / *middle;

  auto map = map_.write();
  const SE3 T_21(problem.poses[1].R(), Eigen::Vector3d(problem.poses[1].t() * scale));
  // As in insert(), of copies.
  report.first = map->begin_submap(request.first.frame, request.first.stamp, SE3(),
                                 std::make_shared<Features>(*request.first.features));
  const uint32_t submap = map->at(report.first).submap;
  report.key_frame = map->add_key_frame(request.second.frame, request.second.stamp, T_21,
                                        std::make_shared<Features>(*request.second.features), submap);
  if (!report.key_frame.valid()) {
    map->erase_submap(submap);
    report.first = {};
    return report;
  }
  for (size_t p = 0; p < good.size(); ++p) {
    if (!good[p]) continue;
    const MapPointId id = map->add_point(problem.points[p] * scale, report.first, request.points[p].feature_first);
    if (!id.valid()) continue;
    map->add_observation(id, report.key_frame, request.points[p].feature_second);
    map->refresh_point(id);
    recent_.push_back({id, map->at(report.key_frame).serial});
    ++report.points_created;
  }
  map->attach_to_tree(report.key_frame);
  map.release();
  add_words(report.first);
  add_words(report.key_frame);
  return report;
}

}  // namespace covis
