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
  Eigen::Vector3d r;            // residuals of u, v, disparity
  bool usable = false;

  Residual(const SE3& T_cw, const PoseObservations& o, const Pinhole& camera, size_t i)
      : p(T_cw.R() * Eigen::Vector3d(o.px[i], o.py[i], o.pz[i]) + T_cw.t()) {
    if (!(p.z() > kMinDepth)) return;
    usable = true;
    iz = 1 / p.z();
    x = p.x() * iz;
    y = p.y() * iz;
    const double u = camera.fx * x + camera.cx;
    const Disparity& d = o.disparity[i];
    r = residual_of(o.u[i] - u, o.v[i] - (camera.fy * y + camera.cy), d.pixels - camera.bf * iz, camera, d);
  }
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
    const Disparity& disparity = o.disparity[i];
    const RobustCost robust = robust_cost(Chi2(residual.r, o.inv_sigma2[i], disparity), camera, disparity, loss);
    s.cost += robust.cost;
    ++s.used;
    if constexpr (kWithJacobian) {
      // d(pixel)/d(xi) for T <- exp(xi) T: dp = rho - p x phi.
      Eigen::Matrix<double, 2, 6> J;
      const double iz = residual.iz, x = residual.x, y = residual.y;
      const double a = camera.fx * iz, b = camera.fy * iz;
      J.row(0) << a, 0, -a * x, -camera.fx * x * y, camera.fx * (1 + x * x), -camera.fx * y;
      J.row(1) << 0, b, -b * y, -camera.fy * (1 + y * y), camera.fy * x * y, camera.fy * x;
      const double w = robust.pixel * static_cast<double>(o.inv_sigma2[i]);
      s.H.noalias() += w * J.transpose() * J;
      s.b.noalias() += J.transpose() * (w * residual.r.head<2>());
      if (!disparity.measured()) continue;
      const double c = camera.bf * iz * iz, w_d = robust.disparity * static_cast<double>(disparity.inv_sigma2);
      const Eigen::Vector3d J_d(-c, -c * residual.p.y(), c * residual.p.x());  // derivatives by t_z, phi_x, phi_y
      if (camera.depth_noise.known()) {
        s.H.block<3, 3>(2, 2).noalias() += w_d * J_d * J_d.transpose();
        s.b.segment<3>(2).noalias() += (w_d * residual.r.z()) * J_d;
      } else {
        Vector6d J_r = J.row(0).transpose();
        J_r.segment<3>(2) -= J_d;
        s.H.noalias() += w_d * J_r * J_r.transpose();
        s.b.noalias() += (w_d * residual.r.z()) * J_r;
      }
    }
  }
  return s;
}

bool finite(const PoseObservations& o, size_t i) {
  return std::isfinite(o.u[i]) && std::isfinite(o.v[i]) && std::isfinite(o.inv_sigma2[i]) &&
         std::isfinite(o.disparity[i].pixels) && std::isfinite(o.disparity[i].inv_sigma2) && std::isfinite(o.px[i]) &&
         std::isfinite(o.py[i]) && std::isfinite(o.pz[i]);
}

int classify(const SE3& T_cw, const PoseObservations& o, const Pinhole& camera, std::vector<uint8_t>& inlier) {
  int count = 0;
  for (size_t i = 0; i < inlier.size(); ++i) {
    inlier[i] = 0;
    if (!finite(o, i)) continue;
    const Residual residual(T_cw, o, camera, i);
    inlier[i] =
        residual.usable && within_bound(Chi2(residual.r, o.inv_sigma2[i], o.disparity[i]), camera, o.disparity[i]);
    count += inlier[i];
  }
  return count;
}

}  // namespace

void PoseObservations::clear() {
  for (auto* array : {&u, &v, &inv_sigma2}) array->clear();
  disparity.clear();
  for (auto* array : {&px, &py, &pz}) array->clear();
}

void PoseObservations::reserve(size_t n) {
  for (auto* array : {&u, &v, &inv_sigma2}) array->reserve(n);
  disparity.reserve(n);
  for (auto* array : {&px, &py, &pz}) array->reserve(n);
}

void PoseObservations::add(const Eigen::Vector3d& p_w, float u_, float v_, float inv_sigma2_,
                           const Disparity& disparity_) {
  u.push_back(u_);
  v.push_back(v_);
  inv_sigma2.push_back(inv_sigma2_);
  disparity.push_back(disparity_);
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
