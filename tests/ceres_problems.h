// SPDX-License-Identifier: Apache-2.0
// For the tests of optimization: the residual of our problems as Ceres takes it.
#pragma once

#include <ceres/ceres.h>
#include <ceres/rotation.h>

#include <cmath>
#include <vector>

#include "covis/optimization/pose_optimization.h"
#include "covis/optimization/test_problems.h"

namespace covis {

// Angle-axis and translation, for Ceres.
struct CeresPose {
  double v[6];
  explicit CeresPose(const SE3& T) {
    ceres::RotationMatrixToAngleAxis(T.R().data(), v);
    for (int k = 0; k < 3; ++k) v[3 + k] = T.t()(k);
  }
};

struct Reprojection {
  double u, v, weight;  // weight: 1 / sigma
  Disparity disparity;
  template <class T>
  bool operator()(const T* pose, const T* point, T* r) const {
    T p[3];
    ceres::AngleAxisRotatePoint(pose, point, p);
    for (int k = 0; k < 3; ++k) p[k] += pose[3 + k];
    const T x = kCamera.fx * p[0] / p[2] + kCamera.cx;
    r[0] = (u - x) * weight;
    r[1] = (v - (kCamera.fy * p[1] / p[2] + kCamera.cy)) * weight;
    const double disparity_weight = std::sqrt(static_cast<double>(disparity.inv_sigma2));
    const T right = u - static_cast<double>(disparity.pixels) - (x - kCamera.bf / p[2]);
    r[2] = disparity.measured() ? right * disparity_weight : T(0);
    return true;
  }
};

inline ceres::CostFunction* make_cost(double u, double v, double inv_sigma2, const Disparity& disparity) {
  return new ceres::AutoDiffCostFunction<Reprojection, 3, 6, 3>(
      new Reprojection{u, v, std::sqrt(inv_sigma2), disparity});
}

// The cost Ceres ends with, twice its own (which halves).
inline double ceres_cost(const BundleProblem& problem, bool robust) {
  std::vector<CeresPose> poses(problem.poses.begin(), problem.poses.end());
  std::vector<Eigen::Vector3d> points = problem.points;
  ceres::Problem theirs;
  for (const BundleObservation& o : problem.observations) {
    if (!o.active) continue;
    const double bound = std::sqrt(o.disparity.measured() ? kChi2Stereo : kChi2Mono);
    theirs.AddResidualBlock(make_cost(o.u, o.v, o.inv_sigma2, o.disparity),
                            robust ? new ceres::HuberLoss(bound) : nullptr, poses[static_cast<size_t>(o.pose)].v,
                            points[static_cast<size_t>(o.point)].data());
  }
  for (size_t c = 0; c < poses.size(); ++c) {
    if (problem.fixed[c] && theirs.HasParameterBlock(poses[c].v)) theirs.SetParameterBlockConstant(poses[c].v);
  }
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::SPARSE_SCHUR;
  options.max_num_iterations = 200;
  options.function_tolerance = 1e-14;
  options.gradient_tolerance = 1e-14;
  options.parameter_tolerance = 1e-14;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &theirs, &summary);
  return 2 * summary.final_cost;
}

}  // namespace covis
