// SPDX-License-Identifier: Apache-2.0
// Similarities Sim(3): p_a = scale * R * p_b + t, written S_ab. Tangent vectors are [rho; phi; sigma], translation
// first, the logarithm of the scale last, and perturb on the left: S <- exp(xi) * S.
// Source: Strasdat, "Local accuracy and global consistency for efficient visual SLAM", 2012, section 2.4 and appendix
// A.
#pragma once

#include "covis/geometry/se3.h"

namespace covis {

using Vector7d = Eigen::Matrix<double, 7, 1>;
using Matrix7d = Eigen::Matrix<double, 7, 7>;

class Sim3 {
 public:
  Sim3() = default;  // the identity
  Sim3(const Eigen::Matrix3d& R, const Eigen::Vector3d& t, double scale) : R_(R), t_(t), scale_(scale) {}
  explicit Sim3(const SE3& T, double scale = 1) : R_(T.R()), t_(T.t()), scale_(scale) {}

  const Eigen::Matrix3d& R() const { return R_; }
  const Eigen::Vector3d& t() const { return t_; }
  double scale() const { return scale_; }

  Sim3 operator*(const Sim3& other) const;
  Eigen::Vector3d operator*(const Eigen::Vector3d& p) const { return scale_ * (R_ * p) + t_; }
  Sim3 inverse() const;

  // The rigid camera pose that is equivalent to this similarity: a camera sees the same pixels when its world is
  // scaled, so [s R, t] and [R, t / s] are the same view.
  SE3 as_pose() const;
  Sim3 normalized() const;
  bool all_finite() const;

  static Sim3 exp(const Vector7d& xi);
  Vector7d log() const;
  // Adj(S): S * exp(xi) = exp(Adj(S) * xi) * S.
  Matrix7d adjoint() const;
  // J_l: exp(xi + d) = exp(J_l(xi) * d) * exp(xi), for small d.
  static Matrix7d left_jacobian(const Vector7d& xi);

 private:
  Eigen::Matrix3d R_ = Eigen::Matrix3d::Identity();
  Eigen::Vector3d t_ = Eigen::Vector3d::Zero();
  double scale_ = 1;
};

}  // namespace covis
