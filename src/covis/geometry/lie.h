// SPDX-License-Identifier: Apache-2.0
// Common code of the Lie groups: the function (e^M - I) M^-1 = sum M^k / (k + 1)! of a square matrix. For a group's
// tangent matrix it is the V (or W) of exp's translation; for its adjoint matrix ad(xi) it is the left Jacobian.
// Source: Higham, "Functions of Matrices", 2008, section 10.7.4: halving and doubling,
// phi(2 M) = (e^M + I) phi(M) / 2; Strasdat, "Local accuracy and global consistency for efficient visual SLAM", 2012.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <limits>

namespace covis {

template <int N>
Eigen::Matrix<double, N, N> phi_function(Eigen::Matrix<double, N, N> M) {
  using Matrix = Eigen::Matrix<double, N, N>;
  if (!M.allFinite()) return Matrix::Constant(std::numeric_limits<double>::quiet_NaN());
  int halvings = 0;
  for (double norm = M.cwiseAbs().maxCoeff(); norm > 0.25; norm /= 2) ++halvings;
  M *= std::ldexp(1.0, -halvings);
  // Horner scheme: with 14 terms the truncation error is below rounding for a norm of N / 4.
  Matrix phi = Matrix::Identity();
  for (int k = 15; k >= 2; --k) phi = Matrix::Identity() + M * phi / k;
  Matrix power = Matrix::Identity() + M * phi;  // e^M
  for (; halvings > 0; --halvings) {
    phi = (0.5 * (power * phi + phi)).eval();
    power = (power * power).eval();
  }
  return phi;
}

}  // namespace covis
