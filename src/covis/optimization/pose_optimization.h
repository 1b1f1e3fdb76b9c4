// SPDX-License-Identifier: Apache-2.0
// Pose of one camera from known points: 6 unknowns, robust, with outlier rounds.
// Source: Mur-Artal and Tardós, "ORB-SLAM2", T-RO 2017, section III-C ("motion-only BA"); chi-square bounds at 95 %.
// The cost is  sum rho( |z - h(T_cw p)|^2 * inv_sigma2 )  with 2 rows (u, v), or 3 (u, v, u_right) when u_right >= 0;
// Huber's rho; xi perturbs on the left: T <- exp(xi) T.
#pragma once

#include <cstdint>
#include <vector>

#include "covis/core/aligned.h"
#include "covis/geometry/camera.h"
#include "covis/geometry/se3.h"

namespace covis {

// chi-square at 95 % for 2 and 3 degrees of freedom.
inline constexpr double kChi2Mono = 5.991;
inline constexpr double kChi2Stereo = 7.815;

// Flat arrays, one entry an observation.
struct PoseObservations {
  AlignedVector<float> u, v, u_right;  // pixels, undistorted; u_right < 0: none
  AlignedVector<float> inv_sigma2;     // 1 / pixels^2
  AlignedVector<double> px, py, pz;    // world point, metres

  int size() const { return static_cast<int>(u.size()); }
  void clear();
  void reserve(size_t n);
  void add(const Eigen::Vector3d& p_w, float u, float v, float u_right, float inv_sigma2);
};

struct PoseOptions {
  int rounds = 4;       // after each, observations are classified again by chi-square
  int iterations = 10;  // greatest number in a round
};

struct PoseResult {
  SE3 T_cw;
  int inliers = 0;  // observations within their chi-square bound at the end, in front of the camera
  double cost = 0;  // robust cost over the inliers
  Matrix6d information =
      Matrix6d::Zero();  // information of xi (translation first), from the last step; its inverse: covariance
  bool ok =
      false;  // false: fewer than 3 usable observations, or a singular or non-finite system; T_cw is the start then
};

// inlier[i] (resized) tells which observations agree at the end. Allocates nothing once `inlier` has the capacity.
PoseResult optimize_pose(const SE3& T_cw_start, const PoseObservations& observations, const Pinhole& camera,
                         const PoseOptions& options, std::vector<uint8_t>& inlier);

}  // namespace covis
