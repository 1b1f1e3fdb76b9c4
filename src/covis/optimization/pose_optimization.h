// SPDX-License-Identifier: Apache-2.0
// Pose of one camera from known points: 6 unknowns, robust, with repeated outlier classification.
// Source: Mur-Artal and Tardós, "ORB-SLAM2", T-RO 2017, section III-C ("motion-only BA"); chi-square bounds at 95 %.
// The cost is  sum rho( |z - h(T_cw p)|^2 / sigma^2 )  with 2 rows (u, v), or 3 when a disparity was measured; rho is
// robust_cost() of reprojection.h; xi perturbs on the left: T <- exp(xi) T. The first round is of pixels alone, where
// there are many, and later ones leave out the depths of a depth sensor that are off by more than their bound: near
// depths are so precise that those of a few things which move by themselves would outvote all others
// (docs/notes/061-things-that-move.md).
#pragma once

#include <cstdint>
#include <vector>

#include "covis/core/aligned.h"
#include "covis/geometry/measurement.h"
#include "covis/geometry/se3.h"

namespace covis {

// Flat arrays, one entry per observation.
struct PoseObservations {
  AlignedVector<float> u, v;        // pixels, undistorted
  AlignedVector<float> inv_sigma2;  // weight of u and v, 1 / pixels^2
  AlignedVector<Disparity> disparity;
  AlignedVector<double> px, py, pz;  // world point, metres
  AlignedVector<uint8_t> leads;      // 0: takes part in the last round alone, at the pose that the others found

  int size() const { return static_cast<int>(u.size()); }
  void clear();
  void reserve(size_t n);
  void add(const Eigen::Vector3d& p_w, float u, float v, float inv_sigma2, const Disparity& disparity = {},
           bool leading = true);
};

struct PoseOptions {
  int rounds = 4;       // number of rounds; after each, observations are classified again by chi-square
  int iterations = 10;  // greatest number of iterations in a round
};

struct PoseResult {
  SE3 T_cw;
  int inliers = 0;  // number of observations in front of the camera and within their chi-square bound at the end
  double cost = 0;  // over the inliers, squared but for the depths of a depth sensor
  // Information of xi (translation first) from the last step; its inverse is the covariance.
  Matrix6d information = Matrix6d::Zero();
  // False: fewer than 3 usable observations, or a singular or non-finite system. T_cw is then the initial pose.
  bool ok = false;
};

// inlier[i] (resized) is 1 for the inliers at the end. Allocates nothing once `inlier` has the capacity.
PoseResult optimize_pose(const SE3& T_cw_start, const PoseObservations& observations, const Pinhole& camera,
                         const PoseOptions& options, std::vector<uint8_t>& inlier);

}  // namespace covis
