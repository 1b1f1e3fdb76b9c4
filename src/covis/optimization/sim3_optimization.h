// SPDX-License-Identifier: Apache-2.0
// The similarity between two cameras that see the same place, each with points of its own map: found among wrong
// matches (ransac_sim3), then refined on the pixels of both images (refine_sim3). Closes loops and finds places again.
// Source: Mur-Artal, Montiel, Tardós, "ORB-SLAM", T-RO 2015, section VII-B and appendix (the cost, both images); Horn,
// "Closed-form solution of absolute orientation using unit quaternions", JOSA A 1987; Fischler and Bolles, CACM 1981.
// S_12 takes camera 2's coordinates to camera 1's: p_1 = S_12 * p_2. The cost is the sum over matches of
//   rho(|z_1 - h_1(S_12 p_2)|^2 inv_sigma2_1) + rho(|z_2 - h_2(S_12^-1 p_1)|^2 inv_sigma2_2).
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "covis/geometry/camera.h"
#include "covis/geometry/sim3.h"

namespace covis {

struct Sim3Match {
  Eigen::Vector3d p_1, p_2;  // the point as each camera's own map has it, in camera 1's and camera 2's coordinates
  Eigen::Vector2d z_1, z_2;  // its place in each image: pixels, undistorted
  double inv_sigma2_1 = 1, inv_sigma2_2 = 1;  // 1 / pixels^2
};

struct Sim3Result {
  Sim3 S_12;
  int inliers = 0;
  std::vector<uint8_t> inlier;  // for each match: in front of both cameras, both squared errors within the bound
  double cost = 0;              // over the inliers, without rho
  bool ok = false;              // false: fewer than 3 matches agree, or a singular system; S_12 is the start then
};

inline constexpr double kRefineChi2 = 10.0;   // Huber's bound too
inline constexpr double kRansacChi2 = 9.210;  // 99 % for 2 degrees of freedom

// Levenberg-Marquardt: 5 iterations with Huber's rho, matches beyond max_chi2 in an image dropped, then 10 more without
// rho (5 if none were dropped). For matches of which most are right: ransac_sim3's inliers, or those that a search
// guided by its similarity found (half of them wrong is too much for rho). With fix_scale the scale stays as it is.
Sim3Result refine_sim3(const Sim3& S_12, std::span<const Sim3Match> matches, const Pinhole& camera_1,
                       const Pinhole& camera_2, bool fix_scale, double max_chi2 = kRefineChi2);

// Models from 3 matches, at most 300, until a sample without a wrong match was drawn with 99 %; the one most matches
// agree with, fitted again to those. Nothing when fewer than min_inliers agree.
std::optional<Sim3Result> ransac_sim3(std::span<const Sim3Match> matches, const Pinhole& camera_1,
                                      const Pinhole& camera_2, bool fix_scale, uint64_t seed, int min_inliers = 20);

// z - h of both images, and d h / d xi for S_12 <- exp(xi) S_12. False: the point is behind a camera, or not finite.
bool sim3_residual(const Sim3& S_12, const Sim3Match& match, const Pinhole& camera_1, const Pinhole& camera_2,
                   Eigen::Vector4d& e, Eigen::Matrix<double, 4, 7>* J = nullptr);

}  // namespace covis
