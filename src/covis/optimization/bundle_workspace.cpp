// SPDX-License-Identifier: Apache-2.0
#include "covis/optimization/bundle_workspace.h"

#include <limits>

#include "covis/optimization/observation_blocks.h"
#include "covis/optimization/reprojection.h"

namespace covis {
namespace {

// With more free poses than this the reduced system is stored sparse.
constexpr size_t kDensePoses = 64;

}  // namespace

void BundleAdjuster::Workspace::prepare(const BundleProblem& problem) {
  const size_t points = problem.points.size();
  offset.assign(points + 1, 0);
  for (const BundleObservation& o : problem.observations) {
    if (o.active) ++offset[static_cast<size_t>(o.point) + 1];
  }
  for (size_t p = 0; p < points; ++p) offset[p + 1] += offset[p];
  sorted.resize(offset[points]);
  std::vector<uint32_t> next(offset.begin(), offset.end() - 1);
  for (const BundleObservation& o : problem.observations) {
    if (o.active) sorted[next[static_cast<size_t>(o.point)]++] = o;
  }
  std::vector<uint32_t> seen(problem.poses.size(), 0);
  point_moves.assign(points, 0);
  for (size_t p = 0; p < points; ++p) {
    uint32_t rows = 0;
    for (uint32_t k = offset[p]; k < offset[p + 1]; ++k) {
      rows += sorted[k].disparity.measured() ? 3 : 2;
      ++seen[static_cast<size_t>(sorted[k].pose)];
    }
    point_moves[p] = rows >= 3;  // fewer rows leave the point undetermined: it does not move
  }
  free_pose.assign(problem.poses.size(), -1);
  free_index.clear();
  for (size_t c = 0; c < problem.poses.size(); ++c) {
    if (problem.fixed[c] || seen[c] == 0) continue;
    free_pose[c] = static_cast<int32_t>(free_index.size());
    free_index.push_back(static_cast<int32_t>(c));
  }
  sparse = free_index.size() > kDensePoses;
  if (sparse) prepare_sparse();
}

double BundleAdjuster::Workspace::cost(const BundleProblem& problem, const std::vector<SE3>& poses,
                                       const std::vector<Eigen::Vector3d>& points, Loss loss) const {
  double total = 0;
  for (size_t k = 0; k < sorted.size(); ++k) {
    const BundleObservation& o = sorted[k];
    const Eigen::Vector3d p_c = poses[static_cast<size_t>(o.pose)] * points[static_cast<size_t>(o.point)];
    if (!(p_c.z() > kMinDepth)) {
      if (used[k]) return std::numeric_limits<double>::infinity();  // a step must not move a point behind a camera
      continue;
    }
    const Eigen::Vector3d e = reprojection_residual(p_c, problem.camera, o.u, o.v, o.disparity);
    if (used[k]) total += robust_cost(Chi2(e, o.inv_sigma2, o.disparity), problem.camera, o.disparity, loss).cost;
  }
  return total;
}

double BundleAdjuster::Workspace::linearise(const BundleProblem& problem, Loss loss) {
  const size_t points = problem.points.size();
  U.assign(free_index.size(), Matrix6d::Zero());
  b_c.assign(free_index.size(), Vector6d::Zero());
  V.assign(points, Eigen::Matrix3d::Zero());
  b_p.assign(points, Eigen::Vector3d::Zero());
  W.resize(sorted.size());
  used.assign(sorted.size(), 0);
  double total = 0;
  WeightedJacobians jacobians;
  for (size_t k = 0; k < sorted.size(); ++k) {
    const BundleObservation& o = sorted[k];
    const auto p = static_cast<size_t>(o.point);
    const SE3& T = problem.poses[static_cast<size_t>(o.pose)];
    const Eigen::Vector3d p_c = T * problem.points[p];
    if (!(p_c.z() > kMinDepth)) {
      W[k].setZero();
      continue;
    }
    used[k] = 1;
    const Eigen::Vector3d e = reprojection_residual(p_c, problem.camera, o.u, o.v, o.disparity);
    const RobustCost robust = robust_cost(Chi2(e, o.inv_sigma2, o.disparity), problem.camera, o.disparity, loss);
    total += robust.cost;
    const double pixel = robust.pixel * static_cast<double>(o.inv_sigma2);
    const Eigen::Vector3d weight(pixel, pixel, robust.disparity * static_cast<double>(o.disparity.inv_sigma2));
    const Eigen::Matrix3d J_pi = projection_jacobian(p_c, problem.camera, o.disparity);
    const Eigen::Matrix3d J_p = J_pi * T.R();
    const Eigen::Matrix3d wJ_p = weight.asDiagonal() * J_p;
    V[p].noalias() += J_p.transpose() * wJ_p;
    b_p[p].noalias() += wJ_p.transpose() * e;
    const int32_t c = free_pose[static_cast<size_t>(o.pose)];
    if (c < 0) continue;
    jacobians.J_p = J_p;
    jacobians.J_c = pose_jacobian(J_pi, p_c).transpose();
    jacobians.wJ_c.noalias() = jacobians.J_c * weight.asDiagonal();
    add_observation(jacobians, e, U[static_cast<size_t>(c)], b_c[static_cast<size_t>(c)], W[k]);
  }
  return total;
}

}  // namespace covis
