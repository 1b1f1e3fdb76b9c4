// SPDX-License-Identifier: Apache-2.0
// The Jacobians of the residual common to all problems here: z - h(T_cw p), with h of geometry/measurement.h.
// Source: Solà et al., "A micro Lie theory", 2018.
#pragma once

#include <Eigen/Core>
#include <cmath>

#include "covis/geometry/measurement.h"
#include "covis/geometry/se3.h"

namespace covis {

using Matrix3x6d = Eigen::Matrix<double, 3, 6>;

// The function of a squared error that is summed up to the cost.
enum class Loss { squared, huber };

// Returns d h / d p_c; row 2 is 0 without a disparity.
inline Eigen::Matrix3d projection_jacobian(const Eigen::Vector3d& p_c, const Pinhole& camera,
                                           const Disparity& disparity) {
  const double iz = 1 / p_c.z(), iz2 = iz * iz;
  Eigen::Matrix3d J;
  J << camera.fx * iz, 0, -camera.fx * p_c.x() * iz2,  //
      0, camera.fy * iz, -camera.fy * p_c.y() * iz2,   //
      0, 0, 0;
  if (!disparity.measured()) return J;
  J(2, 2) = -camera.bf * iz2;
  if (!camera.depth_noise.known()) J.row(2) = J.row(0) - J.row(2);
  return J;
}

// Applies d p_c / d xi for T <- exp(xi) T after a projection Jacobian: J_pi * [I, -hat(p_c)].
inline Matrix3x6d pose_jacobian(const Eigen::Matrix3d& J_pi, const Eigen::Vector3d& p_c) {
  Matrix3x6d J;
  J.leftCols<3>() = J_pi;
  J.rightCols<3>() = -J_pi * hat(p_c);
  return J;
}

// Huber's rho: the cost of a squared error, and the weight of its quadratic approximation.
inline double huber(double chi2, double bound, double& weight) {
  if (chi2 <= bound) {
    weight = 1;
    return chi2;
  }
  const double e = std::sqrt(chi2), k = std::sqrt(bound);
  weight = k / e;
  return 2 * k * e - bound;
}

// The robust cost of a measurement, and the factors by which the weights of its rows change.
struct RobustCost {
  double cost = 0;
  double pixel = 1, disparity = 1;
};

// One loss for all rows, as a wrong match spoils them all; but the depth of a depth sensor has a loss of its own, which
// is always Huber's, for it may be wrong alone.
inline RobustCost robust_cost(const Chi2& chi2, const Pinhole& camera, const Disparity& disparity, Loss loss) {
  RobustCost r;
  const bool own_loss = disparity.measured() && camera.depth_noise.known();
  const double joint = own_loss ? chi2.pixel : chi2.sum();
  const double bound = disparity.measured() && !own_loss ? kChi2Stereo : kChi2Mono;
  r.cost = loss == Loss::huber ? huber(joint, bound, r.pixel) : joint;
  r.disparity = r.pixel;
  if (own_loss) r.cost += huber(chi2.disparity, kChi2One, r.disparity);
  return r;
}

}  // namespace covis
