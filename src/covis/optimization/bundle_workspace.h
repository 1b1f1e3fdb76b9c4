// SPDX-License-Identifier: Apache-2.0
// The memory of bundle adjustment: one linear step's system and its solution. Inside of bundle_adjustment.h, no
// interface.
//
// With e = z - h, J_c and J_p the Jacobians of h, and weights W, one Gauss-Newton step solves
//
//   [ U   W ] [dx_c]   [ b_c ]      U = sum J_c' W J_c,  V = sum J_p' W J_p (3x3 blocks),
//   [ W'  V ] [dx_p] = [ b_p ]      W_cp = J_c' W J_p,   b = J' W e;
//
// eliminating points: (U - W V^-1 W') dx_c = b_c - W V^-1 b_p, then dx_p = V^-1 (b_p - W' dx_c).
// The reduced system is kept dense for few poses (local adjustment); above that as the blocks of poses that see a point
// together (Konolige, "Sparse sparse bundle adjustment", BMVC 2010), so that time and memory follow their number.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "covis/core/aligned.h"
#include "covis/optimization/block_system.h"
#include "covis/optimization/bundle_adjustment.h"
#include "covis/optimization/pose_optimization.h"
#include "covis/optimization/reprojection.h"

namespace covis {

using Matrix6x3d = Eigen::Matrix<double, 6, 3>;

inline double bundle_bound(const BundleObservation& o) { return o.u_right >= 0 ? kChi2Stereo : kChi2Mono; }

struct BundleAdjuster::Workspace {
  // Observations sorted by point; those of point p are [offset[p], offset[p + 1]).
  std::vector<uint32_t> offset;
  std::vector<BundleObservation> sorted;
  std::vector<int32_t> free_pose;   // for each pose its index among the free ones, or -1
  std::vector<int32_t> free_index;  // poses that move
  std::vector<uint8_t> point_moves;

  AlignedVector<Matrix6d> U;
  AlignedVector<Vector6d> b_c;
  AlignedVector<Eigen::Matrix3d> V, V_inv;
  AlignedVector<Eigen::Vector3d> b_p;
  AlignedVector<Matrix6x3d> W;  // for each sorted observation of a free pose; 0 when not used
  std::vector<uint8_t> used;    // for each sorted observation: it is in front of the camera

  Eigen::MatrixXd S;  // lower triangle
  Eigen::VectorXd rhs, step_c;
  AlignedVector<Eigen::Vector3d> step_p;
  std::vector<SE3> poses_try;
  std::vector<Eigen::Vector3d> points_try;
  std::vector<std::pair<int32_t, Matrix6x3d>> row;  // W V^-1 of one point

  bool sparse = false;  // many poses: system instead of S
  BlockSystem<6> system;
  std::vector<uint32_t> slot;  // block of each pair of observations of a point, in add_sparse's order

  void prepare(const BundleProblem& problem);
  double cost(const BundleProblem& problem, const std::vector<SE3>& poses, const std::vector<Eigen::Vector3d>& points,
              Loss loss) const;
  double linearise(const BundleProblem& problem, Loss loss);
  bool solve_step(double lambda);

 private:
  void prepare_sparse();
  std::vector<BlockPair> co_observing() const;
  void start_reduced(double lambda);
  void add_dense();
  void add_sparse(size_t& next_slot);
  bool solve_reduced();

  // Observation k's pose among the free ones, or -1.
  int32_t free_of(uint32_t k) const { return free_pose[static_cast<size_t>(sorted[k].pose)]; }
};

}  // namespace covis
