// SPDX-License-Identifier: Apache-2.0
#include "covis/geometry/se3.h"

#include <cmath>

#include "covis/geometry/lie.h"

namespace covis {
namespace {

// Evaluates sin(x)/x, (1 - cos x)/x^2 and (x - sin x)/x^3, by their Taylor series near 0.
struct Coefficients {
  double a, b, c;
  explicit Coefficients(double theta2) {
    if (theta2 < 1e-8) {
      a = 1 - theta2 / 6;
      b = 0.5 - theta2 / 24;
      c = 1.0 / 6 - theta2 / 120;
    } else {
      const double theta = std::sqrt(theta2);
      a = std::sin(theta) / theta;
      b = (1 - std::cos(theta)) / theta2;
      c = (1 - a) / theta2;
    }
  }
};

}  // namespace

Eigen::Matrix3d hat(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

Eigen::Matrix3d so3_exp(const Eigen::Vector3d& phi) {
  const Coefficients k(phi.squaredNorm());
  const Eigen::Matrix3d w = hat(phi);
  return Eigen::Matrix3d::Identity() + k.a * w + k.b * w * w;
}

Eigen::Vector3d so3_log(const Eigen::Matrix3d& R) {
  Eigen::Quaterniond q(R);
  q.normalize();
  if (q.w() < 0) q.coeffs() *= -1;
  const double n = q.vec().norm();
  if (n < 1e-10) return 2 * q.vec();
  return 2 * std::atan2(n, q.w()) / n * q.vec();
}

Eigen::Matrix3d so3_left_jacobian(const Eigen::Vector3d& phi) {
  const Coefficients k(phi.squaredNorm());
  const Eigen::Matrix3d w = hat(phi);
  return Eigen::Matrix3d::Identity() + k.b * w + k.c * w * w;
}

SE3::SE3(const Eigen::Quaterniond& q, const Eigen::Vector3d& t) : R_(q.normalized().toRotationMatrix()), t_(t) {}

Eigen::Quaterniond SE3::q() const { return Eigen::Quaterniond(R_).normalized(); }

SE3 SE3::normalized() const { return {Eigen::Quaterniond(R_).normalized(), t_}; }

bool SE3::all_finite() const { return R_.allFinite() && t_.allFinite(); }

SE3 SE3::exp(const Vector6d& xi) {
  const Eigen::Vector3d rho = xi.head<3>(), phi = xi.tail<3>();
  return {so3_exp(phi), Eigen::Vector3d(so3_left_jacobian(phi) * rho)};
}

Vector6d SE3::log() const {
  const Eigen::Vector3d phi = so3_log(R_);
  Vector6d xi;
  xi << so3_left_jacobian(phi).partialPivLu().solve(t_), phi;
  return xi;
}

Matrix6d SE3::adjoint() const {
  Matrix6d A = Matrix6d::Zero();
  A.topLeftCorner<3, 3>() = R_;
  A.bottomRightCorner<3, 3>() = R_;
  A.topRightCorner<3, 3>() = hat(t_) * R_;
  return A;
}

Matrix6d SE3::left_jacobian(const Vector6d& xi) {
  Matrix6d ad = Matrix6d::Zero();  // ad(xi) * eta = [xi, eta]
  ad.topLeftCorner<3, 3>() = ad.bottomRightCorner<3, 3>() = hat(xi.tail<3>());
  ad.topRightCorner<3, 3>() = hat(xi.head<3>());
  return phi_function<6>(ad);
}

}  // namespace covis
