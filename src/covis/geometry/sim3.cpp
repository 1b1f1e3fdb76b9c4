// SPDX-License-Identifier: Apache-2.0
#include "covis/geometry/sim3.h"

#include <Eigen/LU>
#include <cmath>

#include "covis/geometry/lie.h"

namespace covis {
namespace {

// The rotation and scale block of the tangent matrix.
Eigen::Matrix3d tangent_matrix(const Eigen::Vector3d& phi, double sigma) {
  Eigen::Matrix3d M = hat(phi);
  M.diagonal().array() += sigma;
  return M;
}

}  // namespace

Sim3 Sim3::operator*(const Sim3& other) const {
  return {R_ * other.R_, scale_ * (R_ * other.t_) + t_, scale_ * other.scale_};
}

Sim3 Sim3::inverse() const {
  const Eigen::Matrix3d Rt = R_.transpose();
  return {Rt, -(Rt * t_) / scale_, 1 / scale_};
}

SE3 Sim3::as_pose() const { return SE3(R_, Eigen::Vector3d(t_ / scale_)).normalized(); }

Sim3 Sim3::normalized() const { return {Eigen::Quaterniond(R_).normalized().toRotationMatrix(), t_, scale_}; }

bool Sim3::all_finite() const { return R_.allFinite() && t_.allFinite() && std::isfinite(scale_) && scale_ > 0; }

Sim3 Sim3::exp(const Vector7d& xi) {
  const Eigen::Vector3d phi = xi.segment<3>(3);
  const Eigen::Matrix3d W = phi_function<3>(tangent_matrix(phi, xi(6)));
  return {so3_exp(phi), W * xi.head<3>(), std::exp(xi(6))};
}

Vector7d Sim3::log() const {
  const Eigen::Vector3d phi = so3_log(R_);
  const double sigma = std::log(scale_);
  Vector7d xi;
  xi << phi_function<3>(tangent_matrix(phi, sigma)).partialPivLu().solve(t_), phi, sigma;
  return xi;
}

Matrix7d Sim3::adjoint() const {
  Matrix7d A = Matrix7d::Zero();
  A.topLeftCorner<3, 3>() = scale_ * R_;
  A.block<3, 3>(0, 3) = hat(t_) * R_;
  A.topRightCorner<3, 1>() = -t_;
  A.block<3, 3>(3, 3) = R_;
  A(6, 6) = 1;
  return A;
}

Matrix7d Sim3::left_jacobian(const Vector7d& xi) {
  const Eigen::Vector3d rho = xi.head<3>(), phi = xi.segment<3>(3);
  Matrix7d ad = Matrix7d::Zero();  // ad(xi) * eta = [xi, eta]
  ad.topLeftCorner<3, 3>() = tangent_matrix(phi, xi(6));
  ad.block<3, 3>(0, 3) = hat(rho);
  ad.topRightCorner<3, 1>() = -rho;
  ad.block<3, 3>(3, 3) = hat(phi);
  return phi_function<7>(ad);
}

}  // namespace covis
