// SPDX-License-Identifier: Apache-2.0
// The workspace of bundle adjustment: the system of one linear step and its solution. Internal to bundle_adjustment.h.
//
// With e = z - h, J_c and J_p the Jacobians of h, and weights W, one Gauss-Newton step solves
//
//   [ U   W ] [dx_c]   [ b_c ]      U = sum J_c' W J_c,  V = sum J_p' W J_p (3x3 blocks),
//   [ W'  V ] [dx_p] = [ b_p ]      W_cp = J_c' W J_p,   b = J' W e;
//
// eliminating points: (U - W V^-1 W') dx_c = b_c - W V^-1 b_p, then dx_p = V^-1 (b_p - W' dx_c).
// The reduced system is dense for few poses (local adjustment). For more it holds only the blocks of pose pairs that
// observe a common point (Konolige, "Sparse sparse bundle adjustment", BMVC 2010), so that time and memory grow with
// the number of such blocks.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "covis/core/aligned.h"
#include "covis/optimization/block_system.h"
#include "covis/optimization/bundle_adjustment.h"
#include "covis/optimization/pose_optimization.h"
#include "covis/optimization/reduced_blocks.h"
#include "covis/optimization/reprojection.h"

namespace covis {

struct BundleAdjuster::Workspace {
  // Observations sorted by point; those of point p are [offset[p], offset[p + 1]).
  std::vector<uint32_t> offset;
  std::vector<BundleObservation> sorted;
  std::vector<int32_t> free_pose;   // index among the free poses, or -1, for each pose
  std::vector<int32_t> free_index;  // poses that move
  std::vector<uint8_t> point_moves;

  AlignedVector<Matrix6d> U;
  AlignedVector<Vector6d> b_c;
  AlignedVector<Eigen::Matrix3d> V, V_inv;
  AlignedVector<Eigen::Vector3d> b_p;
  AlignedVector<Matrix6x3d> W;  // one per sorted observation of a free pose; 0 when not used
  std::vector<uint8_t> used;    // one per sorted observation: 1 when in front of the camera

  Eigen::MatrixXd S;  // lower triangle
  Eigen::VectorXd rhs, step_c;
  AlignedVector<Eigen::Vector3d> step_p;
  std::vector<SE3> poses_try;
  std::vector<Eigen::Vector3d> points_try;
  std::vector<PoseOfPoint> row;  // the free poses of one point

  bool sparse = false;  // true: many poses, `system` is used instead of S
  BlockSystem<6> system;
  std::vector<uint32_t> slot;  // block of each pair of observations of a point, in the order of add_sparse

  void prepare(const BundleProblem& problem);
  double cost(const BundleProblem& problem, const std::vector<SE3>& poses, const std::vector<Eigen::Vector3d>& points,
              Loss loss) const;
  double linearise(const BundleProblem& problem, Loss loss);
  bool solve_step(double lambda);

 private:
  void prepare_sparse();
  std::vector<BlockPair> co_observing() const;
  void start_reduced(double lambda);
  void add_sparse(size_t& next_slot);
  bool solve_reduced();

  // Returns the index of observation k's pose among the free ones, or -1.
  int32_t free_of(uint32_t k) const { return free_pose[static_cast<size_t>(sorted[k].pose)]; }
};

}  // namespace covis
