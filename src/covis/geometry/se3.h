// SPDX-License-Identifier: Apache-2.0
// Rigid motions SE(3). T_ab maps a point from frame b to frame a: p_a = T_ab * p_b (architecture.md, decision 11).
// Tangent vectors are [rho; phi], translation first, and perturb on the left: T <- exp(xi) * T.
// Source: Solà, Deray, Atchuthan, "A micro Lie theory for state estimation in robotics", 2018, sections III and IX.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace covis {

using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

// The skew-symmetric matrix of v: hat(v) * w = v x w.
Eigen::Matrix3d hat(const Eigen::Vector3d& v);

// The rotation matrix of the rotation vector phi (radians), and the inverse (angle in [0, pi]).
Eigen::Matrix3d so3_exp(const Eigen::Vector3d& phi);
Eigen::Vector3d so3_log(const Eigen::Matrix3d& R);
// J_l: so3_exp(phi + d) = so3_exp(J_l(phi) * d) * so3_exp(phi), for small d. It is also the V of SE(3)'s exp.
Eigen::Matrix3d so3_left_jacobian(const Eigen::Vector3d& phi);

// Whatever needs more of Eigen than products is in the source: this header is in nearly every other one.
class SE3 {
 public:
  SE3() = default;  // the identity
  SE3(const Eigen::Matrix3d& R, const Eigen::Vector3d& t) : R_(R), t_(t) {}
  SE3(const Eigen::Quaterniond& q, const Eigen::Vector3d& t);

  const Eigen::Matrix3d& R() const { return R_; }
  const Eigen::Vector3d& t() const { return t_; }
  Eigen::Quaterniond q() const;                                      // w may be negative
  Eigen::Vector3d centre() const { return -(R_.transpose() * t_); }  // camera centre O_w of a T_cw

  SE3 operator*(const SE3& other) const { return {R_ * other.R_, R_ * other.t_ + t_}; }
  Eigen::Vector3d operator*(const Eigen::Vector3d& p) const { return R_ * p + t_; }
  SE3 inverse() const { return {Eigen::Matrix3d(R_.transpose()), Eigen::Vector3d(-(R_.transpose() * t_))}; }

  // Returns the same motion with R made orthonormal again (rounding errors grow over many products).
  SE3 normalized() const;
  bool all_finite() const;

  static SE3 exp(const Vector6d& xi);
  Vector6d log() const;
  // Adj(T): T * exp(xi) = exp(Adj(T) * xi) * T.
  Matrix6d adjoint() const;
  // J_l: exp(xi + d) = exp(J_l(xi) * d) * exp(xi), for small d.
  static Matrix6d left_jacobian(const Vector6d& xi);

 private:
  Eigen::Matrix3d R_ = Eigen::Matrix3d::Identity();
  Eigen::Vector3d t_ = Eigen::Vector3d::Zero();
};

}  // namespace covis
