// SPDX-License-Identifier: Apache-2.0
#include "covis/geometry/camera.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstdio>

namespace covis {
namespace {

// Distorts ideal normalised coordinates; also gives the Jacobian.
Eigen::Vector2d brown_conrady(const std::array<double, 5>& k, const Eigen::Vector2d& m, Eigen::Matrix2d& J) {
  const double x = m.x(), y = m.y(), r2 = x * x + y * y;
  const double radial = 1 + r2 * (k[0] + r2 * (k[1] + r2 * k[4]));
  const double slope = 2 * (k[0] + r2 * (2 * k[1] + r2 * 3 * k[4]));  // 2 * d radial / d r2
  const double p1 = k[2], p2 = k[3];
  J(0, 0) = radial + x * x * slope + 2 * p1 * y + 6 * p2 * x;
  J(0, 1) = x * y * slope + 2 * p1 * x + 2 * p2 * y;
  J(1, 0) = J(0, 1);
  J(1, 1) = radial + y * y * slope + 6 * p1 * y + 2 * p2 * x;
  return {x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x), y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y};
}

// theta_d as a function of theta, and its derivative (Kannala and Brandt, eq. 6).
double kannala_brandt(const std::array<double, 5>& k, double theta, double& slope) {
  const double t2 = theta * theta;
  slope = 1 + t2 * (3 * k[0] + t2 * (5 * k[1] + t2 * (7 * k[2] + t2 * 9 * k[3])));
  return theta * (1 + t2 * (k[0] + t2 * (k[1] + t2 * (k[2] + t2 * k[3]))));
}

// Newton iteration from the distorted point. Returns nullopt when it does not converge or ends beyond the fold of the
// lens polynomial.
std::optional<Eigen::Vector2d> undo_brown_conrady(const std::array<double, 5>& k, const Eigen::Vector2d& distorted) {
  Eigen::Vector2d m = distorted;
  Eigen::Matrix2d J;
  for (int i = 0; i < 30; ++i) {
    const Eigen::Vector2d error = brown_conrady(k, m, J) - distorted;
    if (!(J.determinant() > 1e-9)) return std::nullopt;
    const Eigen::Vector2d step = J.inverse() * error;
    m -= step;
    if (!m.allFinite()) return std::nullopt;
    if (step.squaredNorm() < 1e-24) {
      brown_conrady(k, m, J);
      if (!(J.determinant() > 0)) return std::nullopt;
      return m;
    }
  }
  return std::nullopt;
}

std::optional<double> undo_kannala_brandt(const std::array<double, 5>& k, double theta_d) {
  constexpr double kPi = 3.14159265358979323846;
  double theta = std::min(theta_d, kPi / 2), slope = 1;
  for (int i = 0; i < 50; ++i) {
    const double step = (kannala_brandt(k, theta, slope) - theta_d) / slope;
    if (!(slope > 1e-9)) return std::nullopt;
    theta -= step;
    if (std::abs(step) < 1e-13) return theta >= 0 && theta <= kPi && slope > 0 ? std::optional(theta) : std::nullopt;
  }
  return std::nullopt;
}

}  // namespace

std::optional<Eigen::Vector2d> Pinhole::straightened(const Eigen::Vector2d& pixel) const {
  if (!residual.any()) return pixel;
  const auto m = undo_brown_conrady({residual.k1, residual.k2}, unproject(pixel.x(), pixel.y()).head<2>());
  if (!m || !residual.unfolds(m->squaredNorm())) return std::nullopt;
  return project(m->homogeneous());
}

Eigen::Vector2d Pinhole::bent(const Eigen::Vector2d& pixel) const {
  if (!residual.any()) return pixel;
  Eigen::Matrix2d J;
  return project(brown_conrady({residual.k1, residual.k2}, unproject(pixel.x(), pixel.y()).head<2>(), J).homogeneous());
}

std::optional<Eigen::Vector2d> Camera::project(const Eigen::Vector3d& p, Eigen::Matrix<double, 2, 3>* J) const {
  const Eigen::Vector2d f(pinhole.fx, pinhole.fy), c(pinhole.cx, pinhole.cy);
  if (distortion == Distortion::kannala_brandt) {
    const double r2 = p.x() * p.x() + p.y() * p.y(), r = std::sqrt(r2), n2 = r2 + p.z() * p.z();
    if (!(n2 > 0)) return std::nullopt;
    const double theta = std::atan2(r, p.z());
    double slope;
    const double theta_d = kannala_brandt(coefficients, theta, slope);
    if (!(slope > 0)) return std::nullopt;  // the angle is beyond the range of the lens model
    if (r < 1e-12) {
      if (!(p.z() > 0)) return std::nullopt;
      if (J) *J << f.x() / p.z(), 0, 0, 0, f.y() / p.z(), 0;
      return c;
    }
    const Eigen::Vector2d d(p.x() / r, p.y() / r);
    if (J) {
      // d theta = (z dr - r dz) / n2;  d direction = (I - d d') / r.
      Eigen::Matrix<double, 2, 3> m;
      m.leftCols<2>() =
          d * d.transpose() * (slope * p.z() / n2) + (Eigen::Matrix2d::Identity() - d * d.transpose()) * (theta_d / r);
      m.col(2) = d * (-slope * r / n2);
      *J = f.asDiagonal() * m;
    }
    return f.cwiseProduct(d * theta_d) + c;
  }
  if (!(p.z() > 0)) return std::nullopt;
  const double iz = 1 / p.z();
  const Eigen::Vector2d m(p.x() * iz, p.y() * iz);
  Eigen::Matrix<double, 2, 3> J_m;
  J_m << iz, 0, -m.x() * iz, 0, iz, -m.y() * iz;
  if (distortion == Distortion::none) {
    if (J) *J = f.asDiagonal() * J_m;
    return f.cwiseProduct(m) + c;
  }
  Eigen::Matrix2d J_d;
  const Eigen::Vector2d d = brown_conrady(coefficients, m, J_d);
  if (!(J_d.determinant() > 0)) return std::nullopt;  // the polynomial has folded over, which no real lens does
  if (J) *J = f.asDiagonal() * J_d * J_m;
  return f.cwiseProduct(d) + c;
}

std::optional<Eigen::Vector3d> Camera::unproject(const Eigen::Vector2d& pixel) const {
  const Eigen::Vector2d m((pixel.x() - pinhole.cx) / pinhole.fx, (pixel.y() - pinhole.cy) / pinhole.fy);
  switch (distortion) {
    case Distortion::none:
      return m.homogeneous().normalized();
    case Distortion::brown_conrady: {
      const auto ideal = undo_brown_conrady(coefficients, m);
      if (!ideal) return std::nullopt;
      return ideal->homogeneous().normalized();
    }
    case Distortion::kannala_brandt: {
      const double theta_d = m.norm();
      if (theta_d < 1e-12) return Eigen::Vector3d::UnitZ();
      const auto theta = undo_kannala_brandt(coefficients, theta_d);
      if (!theta) return std::nullopt;
      const Eigen::Vector2d d = m / theta_d * std::sin(*theta);
      return Eigen::Vector3d(d.x(), d.y(), std::cos(*theta));
    }
  }
  return std::nullopt;
}

std::optional<Eigen::Vector2d> Camera::undistort(const Eigen::Vector2d& pixel) const {
  const auto ray = unproject(pixel);
  if (!ray || !(ray->z() > 1e-6)) return std::nullopt;
  return pinhole.project(*ray);
}

std::optional<Eigen::Vector2d> image_pixel(const Camera& given, const Pinhole& refined, const Eigen::Vector3d& p_c) {
  if (!(p_c.z() > 0) || !refined.residual.unfolds(p_c.head<2>().squaredNorm() / (p_c.z() * p_c.z())))
    return std::nullopt;
  const Eigen::Vector2d undistorted = refined.bent(refined.project(p_c));
  return given.project(given.pinhole.unproject(undistorted.x(), undistorted.y()));
}

std::string difference(const Camera& camera, const Camera& other) {
  std::string text;
  const auto compare = [&](const std::string& name, double a, double b) {
    constexpr double kDigits = 1e-6;
    if (std::abs(a - b) <= kDigits * std::max(1.0, std::abs(a))) return;
    char figures[64];
    std::snprintf(figures, sizeof figures, " %.6g instead of %.6g", b, a);
    text += (text.empty() ? "" : ", ") + name + figures;
  };
  compare("width", camera.width, other.width);
  compare("height", camera.height, other.height);
  const Pinhole &p = camera.pinhole, &q = other.pinhole;
  compare("fx", p.fx, q.fx);
  compare("fy", p.fy, q.fy);
  compare("cx", p.cx, q.cx);
  compare("cy", p.cy, q.cy);
  compare("baseline", p.baseline(), q.baseline());
  if (camera.distortion != other.distortion) {
    text += text.empty() ? "another lens" : ", another lens";
  } else if (camera.distortion != Distortion::none) {
    for (size_t k = 0; k < camera.coefficients.size(); ++k)
      compare("lens coefficient " + std::to_string(k + 1), camera.coefficients[k], other.coefficients[k]);
  }
  return text;
}

bool same_lens(const Camera& camera, const Camera& other) {
  Camera of_equal_depth = camera;
  of_equal_depth.pinhole.bf = other.pinhole.baseline() * camera.pinhole.fx;
  return difference(of_equal_depth, other).empty();
}

}  // namespace covis
