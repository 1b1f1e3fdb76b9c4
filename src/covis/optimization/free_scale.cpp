// SPDX-License-Identifier: Apache-2.0
#include "covis/optimization/free_scale.h"

#include <utility>

#include "covis/core/quantile.h"

namespace covis {
namespace {

// The median of the factors by which the moved points' distances from the centre of one pose became shorter.
double median_shrinkage(const BundleProblem& problem, size_t pose, const std::vector<uint8_t>& moved,
                        const std::vector<double>& distance_before) {
  std::vector<double> shrinkage;
  const Eigen::Vector3d centre = problem.poses[pose].centre();
  for (size_t p = 0; p < problem.points.size(); ++p) {
    const double now = (problem.points[p] - centre).norm();
    if (moved[p] && now > 0 && distance_before[p] > 0) shrinkage.push_back(distance_before[p] / now);
  }
  return shrinkage.empty() ? 1 : quantile(std::move(shrinkage), 0.5);
}

}  // namespace

std::vector<double> distances_from(size_t pose, const BundleProblem& problem) {
  const Eigen::Vector3d centre = problem.poses[pose].centre();
  std::vector<double> distances;
  for (const Eigen::Vector3d& point : problem.points) distances.push_back((point - centre).norm());
  return distances;
}

void restore_scale(size_t pose, const std::vector<double>& distances, const std::vector<int32_t>& moved_poses,
                   const std::vector<uint8_t>& moved, BundleProblem& problem) {
  const double factor = median_shrinkage(problem, pose, moved, distances);
  const Eigen::Vector3d centre = problem.poses[pose].centre();
  for (const int32_t k : moved_poses) {
    SE3& T_cw = problem.poses[static_cast<size_t>(k)];
    const Eigen::Vector3d scaled = centre + factor * (T_cw.centre() - centre);
    T_cw = SE3(T_cw.R(), Eigen::Vector3d(-(T_cw.R() * scaled)));
  }
  for (size_t p = 0; p < problem.points.size(); ++p) {
    if (moved[p]) problem.points[p] = centre + factor * (problem.points[p] - centre);
  }
}

void restore_scale(size_t pose, const std::vector<double>& distances, BundleProblem& problem) {
  std::vector<int32_t> poses;
  for (size_t k = 0; k < problem.poses.size(); ++k) {
    if (k != pose) poses.push_back(static_cast<int32_t>(k));
  }
  std::vector<uint8_t> points(problem.points.size(), 0);
  for (const BundleObservation& o : problem.observations) points[static_cast<size_t>(o.point)] |= o.active;
  restore_scale(pose, distances, poses, points, problem);
}

}  // namespace covis
