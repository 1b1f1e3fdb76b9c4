// SPDX-License-Identifier: Apache-2.0
#include "covis/optimization/pose_optimization.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
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

// H and b of many observations. The Jacobian of one is J = P [I | -[p]x], for T <- exp(xi) T moves the point p by
// rho - p x phi; so all follows from M = P' W P and g = P' W r.
class NormalEquations {
 public:
  // m: the elements 00, 02, 11, 12, 22 of M, whose element 01 is 0.
  void add(const Eigen::Vector3d& p, const std::array<double, 5>& m, const Eigen::Vector3d& g) {
    const auto [m00, m02, m11, m12, m22] = m;
    const double x = p.x(), y = p.y(), z = p.z();
    // N = M [p]x, and the lower right block [p]x' N.
    const double n00 = -y * m02, n01 = x * m02 - z * m00, n02 = y * m00;
    const double n10 = z * m11 - y * m12, n11 = x * m12, n12 = -x * m11;
    const double n20 = z * m12 - y * m22, n21 = x * m22 - z * m02, n22 = y * m02 - x * m12;
    const std::array<double, 26> terms{m00,
                                       m02,
                                       m11,
                                       m12,
                                       m22,
                                       n00,
                                       n01,
                                       n02,
                                       n10,
                                       n11,
                                       n12,
                                       n20,
                                       n21,
                                       n22,
                                       z * n10 - y * n20,
                                       z * n11 - y * n21,
                                       z * n12 - y * n22,
                                       x * n21 - z * n01,
                                       x * n22 - z * n02,
                                       y * n02 - x * n12,
                                       g.x(),
                                       g.y(),
                                       g.z(),
                                       y * g.z() - z * g.y(),
                                       z * g.x() - x * g.z(),
                                       x * g.y() - y * g.x()};
    for (size_t k = 0; k < terms.size(); ++k) sums_[k] += terms[k];
  }
  void store(PoseSystem& s) const {
    const std::array<double, 26>& t = sums_;
    s.H << t[0], 0, t[1], -t[5], -t[6], -t[7],      //
        0, t[2], t[3], -t[8], -t[9], -t[10],        //
        t[1], t[3], t[4], -t[11], -t[12], -t[13],   //
        -t[5], -t[8], -t[11], t[14], t[15], t[16],  //
        -t[6], -t[9], -t[12], t[15], t[17], t[18],  //
        -t[7], -t[10], -t[13], t[16], t[18], t[19];
    s.b << t[20], t[21], t[22], t[23], t[24], t[25];
  }

 private:
  std::array<double, 26> sums_{};
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

// The part of an observation that a round takes: nothing (0), its pixel, or its depth as well.
enum Part : uint8_t { kPixel = 1, kDepth = 2 };

// Sums residuals and Jacobians of all observations with use[i] != 0, in their order.
template <bool kWithJacobian>
PoseSystem accumulate(const SE3& T_cw, const PoseObservations& o, const Pinhole& camera,
                      const std::vector<uint8_t>& use, Loss loss) {
  PoseSystem s;
  NormalEquations equations;
  const auto n = static_cast<size_t>(o.size());
  for (size_t i = 0; i < n; ++i) {
    if (!use[i]) continue;
    const Residual residual(T_cw, o, camera, i);
    if (!residual.usable) continue;
    const Disparity disparity = use[i] & kDepth ? o.disparity[i] : Disparity{};
    const RobustCost robust = robust_cost(Chi2(residual.r, o.inv_sigma2[i], disparity), camera, disparity, loss);
    s.cost += robust.cost;
    ++s.used;
    if constexpr (kWithJacobian) {
      const double iz = residual.iz, x = residual.x, y = residual.y;
      const double a = camera.fx * iz, b = camera.fy * iz, w = robust.pixel * static_cast<double>(o.inv_sigma2[i]);
      const double w_aa = w * a * a, w_bb = w * b * b, g_u = w * a * residual.r.x(), g_v = w * b * residual.r.y();
      std::array<double, 5> m{w_aa, -w_aa * x, w_bb, -w_bb * y, w_aa * x * x + w_bb * y * y};
      Eigen::Vector3d g(g_u, g_v, -x * g_u - y * g_v);
      if (disparity.measured()) {
        const double w_d = robust.disparity * static_cast<double>(disparity.inv_sigma2), r = residual.r.z();
        // The third row of P: (0, 0, by_z), or (a, 0, by_z) where it is that of the right column.
        const bool alone = camera.depth_noise.known();
        const double c = camera.bf * iz * iz, by_z = alone ? -c : c - a * x;
        m[4] += w_d * by_z * by_z;
        g.z() += w_d * by_z * r;
        if (!alone) {
          m[0] += w_d * a * a;
          m[1] += w_d * a * by_z;
          g.x() += w_d * a * r;
        }
      }
      equations.add(residual.p, m, g);
    }
  }
  if constexpr (kWithJacobian) equations.store(s);
  return s;
}

bool finite(const PoseObservations& o, size_t i) {
  return std::isfinite(o.u[i]) && std::isfinite(o.v[i]) && std::isfinite(o.inv_sigma2[i]) &&
         std::isfinite(o.disparity[i].pixels) && std::isfinite(o.disparity[i].inv_sigma2) && std::isfinite(o.px[i]) &&
         std::isfinite(o.py[i]) && std::isfinite(o.pz[i]);
}

// Fills `use` with what agrees with the pose, of the leading observations or of all, and returns how many do.
enum class Who { leading, all };
int classify(const SE3& T_cw, const PoseObservations& o, const Pinhole& camera, Who who, std::vector<uint8_t>& use) {
  int count = 0;
  for (size_t i = 0; i < use.size(); ++i) {
    use[i] = 0;
    if (!finite(o, i) || (who == Who::leading && !o.leads[i])) continue;
    const Residual residual(T_cw, o, camera, i);
    if (!residual.usable) continue;
    const Disparity& disparity = o.disparity[i];
    const Chi2 chi2(residual.r, o.inv_sigma2[i], disparity);
    if (!within_bound(chi2, camera, disparity)) continue;
    const bool depth_agrees = !camera.depth_noise.known() || chi2.disparity <= kChi2One;
    use[i] = depth_agrees ? kPixel | kDepth : kPixel;
    ++count;
  }
  return count;
}

// Few pixels do not hold a pose as well as their depths do.
uint8_t first_part(const PoseObservations& o) {
  constexpr auto kEnoughPixels = 100;
  const bool enough = std::count(o.leads.begin(), o.leads.end(), 1) >= kEnoughPixels;
  return enough ? kPixel : kPixel | kDepth;
}

}  // namespace

void PoseObservations::clear() {
  for (auto* array : {&u, &v, &inv_sigma2}) array->clear();
  disparity.clear();
  for (auto* array : {&px, &py, &pz}) array->clear();
  leads.clear();
}

void PoseObservations::reserve(size_t n) {
  for (auto* array : {&u, &v, &inv_sigma2}) array->reserve(n);
  disparity.reserve(n);
  for (auto* array : {&px, &py, &pz}) array->reserve(n);
  leads.reserve(n);
}

void PoseObservations::add(const Eigen::Vector3d& p_w, float u_, float v_, float inv_sigma2_,
                           const Disparity& disparity_, bool leading) {
  u.push_back(u_);
  v.push_back(v_);
  inv_sigma2.push_back(inv_sigma2_);
  disparity.push_back(disparity_);
  px.push_back(p_w.x());
  py.push_back(p_w.y());
  pz.push_back(p_w.z());
  leads.push_back(leading);
}

PoseResult optimize_pose(const SE3& T_cw_start, const PoseObservations& observations, const Pinhole& camera,
                         const PoseOptions& options, std::vector<uint8_t>& inlier) {
  PoseResult result;
  result.T_cw = T_cw_start;
  const auto n = static_cast<size_t>(observations.size());
  inlier.resize(n);
  const uint8_t first = first_part(observations);
  for (size_t i = 0; i < n; ++i) inlier[i] = finite(observations, i) && observations.leads[i] ? first : 0;
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
        const bool small = s.cost - next.cost <= 1e-4 * s.cost;
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
    const Who who = round + 2 < options.rounds ? Who::leading : Who::all;
    const int count = classify(T, observations, camera, who, inlier);
    if (count < 3) return result;
    result.inliers = count;
  }
  result.T_cw = T;
  result.cost = accumulate<false>(T, observations, camera, inlier, Loss::squared).cost;
  for (uint8_t& use : inlier) use = use != 0;
  result.ok = true;
  return result;
}

}  // namespace covis
