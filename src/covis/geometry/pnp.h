// SPDX-License-Identifier: Apache-2.0
// A camera's pose from known points, without an initial guess. Source of the minimal solver: Grunert 1841, as given by
// Haralick, Lee, Ottenberg, Nölle, "Review and analysis of solutions of the three point perspective pose estimation
// problem", IJCV 1994, section 3.1; RANSAC: Fischler and Bolles, CACM 1981.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "covis/geometry/camera.h"
#include "covis/geometry/se3.h"

namespace covis {

// Computes the poses T_cw that see the three world points along the three rays (camera coordinates, any length).
// Returns their number, at most 4.
int solve_p3p(const std::array<Eigen::Vector3d, 3>& points_w, const std::array<Eigen::Vector3d, 3>& rays,
              std::array<SE3, 4>& T_cw);

struct PnpProblem {
  std::vector<Eigen::Vector3d> points_w;
  std::vector<Eigen::Vector3d> rays;  // z = 1
  std::vector<double> sigma2;         // pixels^2
  void add(const Eigen::Vector3d& point_w, const Eigen::Vector3d& ray, double s2) {
    points_w.push_back(point_w);
    rays.push_back(ray);
    sigma2.push_back(s2);
  }
};

struct PnpResult {
  SE3 T_cw;
  std::vector<uint8_t> inlier;
  int inliers = 0;
};

// The pose with the most inliers (chi-square 5.991) of at most 300 samples, fewer once 99 % sure. Returns nullopt for
// fewer than 4 observations or fewer than `min_inliers` inliers. The same seed gives the same result.
std::optional<PnpResult> ransac_pnp(const PnpProblem& problem, const Pinhole& camera, uint64_t seed,
                                    int min_inliers = 10);

}  // namespace covis
