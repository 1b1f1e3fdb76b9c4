// SPDX-License-Identifier: Apache-2.0
#include "covis/optimization/pose_optimization.h"

#include <Eigen/Cholesky>
#include <cmath>

#include "covis/optimization/reprojection.h"

namespace covis {
namespace {

struct PoseSystem {
  Matrix6d H;
  Vector6d b;
  double cost = 0;
  int used = 0;
};

// The residual of observation i, and the terms its Jacobian shares with it: the measurement model of
// geometry/measurement.h in the order of operations that is fastest here. `usable` is false unless the point is in
// front of the camera.
struct Residual {
  Eigen::Vector3d p;            // point in camera coordinates
  double iz = 0, x = 0, y = 0;  // 1 / depth, and the point at depth 1
  Eigen::Vector3d r;            // residuals of u, v, u_right
  bool stereo = false, usable = false;

  Residual(const SE3& T_cw, const PoseObservations& o, const Pinhole& camera, size_t i)
      : p(T_cw.R() * Eigen::Vector3d(o.px[i], o.py[i], o.pz[i]) + T_cw.t()) {
    if (!(p.z() > kMinDepth)) return;
    usable = true;
    iz = 1 / p.z();
    x = p.x() * iz;
    y = p.y() * iz;
    const double u = camera.fx * x + camera.cx;
    stereo = o.u_right[i] >= 0;
    r = {o.u[i] - u, o.v[i] - (camera.fy * y + camera.cy), stereo ? o.u_right[i] - (u - camera.bf * iz) : 0};
  }
  double chi2(float inv_sigma2) const { return (r.x() * r.x() + r.y() * r.y() + r.z() * r.z()) * inv_sigma2; }
  double bound() const { return stereo ? kChi2Stereo : kChi2Mono; }
};

// Sums residuals and Jacobians of all observations with use[i] != 0, in their order.
template <bool kWithJacobian>
PoseSystem accumulate(const SE3& T_cw, const PoseObservations& o, const Pinhole& camera,
                      const std::vector<uint8_t>& use, Loss loss) {
  PoseSystem s;
  s.H.setZero();
  s.b.setZero();
  const auto n = static_cast<size_t>(o.size());
  for (size_t i = 0; i < n; ++i) {
    if (!use[i]) continue;
    const Residual residual(T_cw, o, camera, i);
    if (!residual.usable) continue;
    const double w0 = o.inv_sigma2[i];
    const double chi2 = residual.chi2(o.inv_sigma2[i]);
    const double bound = residual.bound();
    double w = w0;
    double rho = chi2;
    if (loss == Loss::huber && chi2 > bound) {
      const double e = std::sqrt(chi2), k = std::sqrt(bound);
      rho = 2 * k * e - bound;
      w *= k / e;
    }
    s.cost += rho;
    ++s.used;
    if constexpr (kWithJacobian) {
      // d(pixel)/d(xi) for T <- exp(xi) T: dp = rho - p x phi.
      Eigen::Matrix<double, 3, 6> J;
      const double iz = residual.iz, x = residual.x, y = residual.y;
      const double a = camera.fx * iz, b = camera.fy * iz;
      J.row(0) << a, 0, -a * x, -camera.fx * x * y, camera.fx * (1 + x * x), -camera.fx * y;
      J.row(1) << 0, b, -b * y, -camera.fy * (1 + y * y), camera.fy * x * y, camera.fy * x;
      if (residual.stereo) {
        const double c = camera.bf * iz * iz;
        J.row(2) = J.row(0);
        J(2, 2) += c;
        J(2, 3) += c * residual.p.y();
        J(2, 4) -= c * residual.p.x();
      } else {
        J.row(2).setZero();
      }
      s.H.noalias() += w * J.transpose() * J;
      s.b.noalias() += J.transpose() * (w * residual.r);
    }
  }
  return s;
}

bool finite(const PoseObservations& o, size_t i) {
  return std::isfinite(o.u[i]) && std::isfinite(o.v[i]) && std::isfinite(o.u_right[i]) &&
         std::isfinite(o.inv_sigma2[i]) && std::isfinite(o.px[i]) && std::isfinite(o.py[i]) && std::isfinite(o.pz[i]);
}

int classify(const SE3& T_cw, const PoseObservations& o, const Pinhole& camera, std::vector<uint8_t>& inlier) {
  int count = 0;
  for (size_t i = 0; i < inlier.size(); ++i) {
    inlier[i] = 0;
    if (!finite(o, i)) continue;
    const Residual residual(T_cw, o, camera, i);
    inlier[i] = residual.usable && residual.chi2(o.inv_sigma2[i]) <= residual.bound();
    count += inlier[i];
  }
  return count;
}

}  // namespace

void PoseObservations::clear() {
  for (auto* array : {&u, &v, &u_right, &inv_sigma2}) array->clear();
  for (auto* array : {&px, &py, &pz}) array->clear();
}

void PoseObservations::reserve(size_t n) {
  for (auto* array : {&u, &v, &u_right, &inv_sigma2}) array->reserve(n);
  for (auto* array : {&px, &py, &pz}) array->reserve(n);
}

void PoseObservations::add(const Eigen::Vector3d& p_w, float u_, float v_, float u_right_, float inv_sigma2_) {
  u.push_back(u_);
  v.push_back(v_);
  u_right.push_back(u_right_);
  inv_sigma2.push_back(inv_sigma2_);
  px.push_back(p_w.x());
  py.push_back(p_w.y());
  pz.push_back(p_w.z());
}

PoseResult optimize_pose(const SE3& T_cw_start, const PoseObservations& observations, const Pinhole& camera,
                         const PoseOptions& options, std::vector<uint8_t>& inlier) {
  PoseResult result;
  result.T_cw = T_cw_start;
  const auto n = static_cast<size_t>(observations.size());
  inlier.resize(n);
  for (size_t i = 0; i < n; ++i) inlier[i] = finite(observations, i);
  SE3 T = T_cw_start;
  for (int round = 0; round < options.rounds; ++round) {
    const Loss loss = round + 1 < options.rounds ? Loss::huber : Loss::squared;
    double lambda = 1e-6;
    PoseSystem s = accumulate<true>(T, observations, camera, inlier, loss);
    for (int k = 0; k < options.iterations; ++k) {
      if (s.used < 3) return result;
      Matrix6d H = s.H;
      H.diagonal() *= 1 + lambda;
      const Vector6d step = H.ldlt().solve(s.b);
      if (!step.allFinite()) return result;
      const SE3 candidate = SE3::exp(step) * T;
      PoseSystem next = accumulate<true>(candidate, observations, camera, inlier, loss);
      if (next.used >= s.used && next.cost <= s.cost) {
        const bool small = s.cost - next.cost <= 1e-6 * s.cost;
        T = candidate;
        s = next;
        lambda = std::max(lambda * 0.1, 1e-9);
        if (small) break;
      } else {
        lambda = std::max(lambda * 10, 1e-4);
        if (step.squaredNorm() < 1e-16) break;
      }
    }
    T = T.normalized();
    result.information = s.H;
    const int count = classify(T, observations, camera, inlier);
    if (count < 3) return result;
    result.inliers = count;
  }
  result.T_cw = T;
  result.cost = accumulate<false>(T, observations, camera, inlier, Loss::squared).cost;
  result.ok = true;
  return result;
}

}  // namespace covis
