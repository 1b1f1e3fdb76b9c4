// SPDX-License-Identifier: Apache-2.0
#include "covis/geometry/pnp.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "covis/core/random.h"
#include "covis/geometry/alignment.h"

namespace covis {
namespace {

// Real roots of sum c[k] v^k, of degree 4; none where c[4] vanishes.
int real_roots(const std::array<double, 5>& c, std::array<double, 4>& roots) {
  if (!(std::abs(c[4]) > 1e-14)) return 0;
  Eigen::Matrix4d companion = Eigen::Matrix4d::Zero();
  for (int k = 0; k < 4; ++k) companion(k, 3) = -c[static_cast<size_t>(k)] / c[4];
  for (int k = 0; k < 3; ++k) companion(k + 1, k) = 1;
  if (!companion.allFinite()) return 0;
  const Eigen::EigenSolver<Eigen::Matrix4d> solver(companion, false);
  int count = 0;
  for (int k = 0; k < 4; ++k) {
    const std::complex<double> root = solver.eigenvalues()(k);
    if (std::abs(root.imag()) > 1e-4 * (1 + std::abs(root.real()))) continue;
    double v = root.real();
    for (int i = 0; i < 3; ++i) {  // Newton steps
      const double f = c[0] + v * (c[1] + v * (c[2] + v * (c[3] + v * c[4])));
      const double slope = c[1] + v * (2 * c[2] + v * (3 * c[3] + v * 4 * c[4]));
      if (slope == 0) break;
      v -= f / slope;
    }
    roots[static_cast<size_t>(count++)] = v;
  }
  return count;
}

}  // namespace

int solve_p3p(const std::array<Eigen::Vector3d, 3>& points, const std::array<Eigen::Vector3d, 3>& rays,
              std::array<SE3, 4>& T_cw) {
  const Eigen::Vector3d f1 = rays[0].normalized(), f2 = rays[1].normalized(), f3 = rays[2].normalized();
  const double a2 = (points[1] - points[2]).squaredNorm(), b2 = (points[0] - points[2]).squaredNorm(),
               c2 = (points[0] - points[1]).squaredNorm();
  if (!((points[1] - points[0]).cross(points[2] - points[0]).squaredNorm() > 1e-12 * b2 * c2) || !(b2 > 0)) return 0;
  const double ca = f2.dot(f3), cb = f1.dot(f3), cg = f1.dot(f2);
  const double p = (a2 - c2) / b2, q = (a2 + c2) / b2;
  const std::array<double, 5> c = {(1 + p) * (1 + p) - 4 * a2 / b2 * cg * cg,
                                   4 * (-p * (1 + p) * cb + 2 * a2 / b2 * cg * cg * cb - (1 - q) * ca * cg),
                                   2 * (p * p - 1 + 2 * p * p * cb * cb + 2 * (b2 - c2) / b2 * ca * ca -
                                        4 * q * ca * cb * cg + 2 * (b2 - a2) / b2 * cg * cg),
                                   4 * (p * (1 - p) * cb - (1 - q) * ca * cg + 2 * c2 / b2 * ca * ca * cb),
                                   (p - 1) * (p - 1) - 4 * c2 / b2 * ca * ca};
  std::array<double, 4> roots{};
  const int count = real_roots(c, roots);
  int solutions = 0;
  for (int k = 0; k < count; ++k) {
    const double v = roots[static_cast<size_t>(k)];
    const double denominator = 2 * (cg - v * ca);
    if (!(v > 0) || std::abs(denominator) < 1e-12) continue;
    const double u = ((p - 1) * v * v - 2 * p * cb * v + 1 + p) / denominator;
    const double s1_squared = b2 / (1 + v * v - 2 * v * cb);
    if (!(u > 0) || !(s1_squared > 0)) continue;
    const double s1 = std::sqrt(s1_squared);
    const std::array<Eigen::Vector3d, 3> in_camera = {s1 * f1, u * s1 * f2, v * s1 * f3};
    const auto aligned = align(points, in_camera, Scale::fixed);
    if (!aligned || !aligned->T_ba.all_finite()) continue;
    T_cw[static_cast<size_t>(solutions++)] = aligned->T_ba;
  }
  return solutions;
}

std::optional<PnpResult> ransac_pnp(const PnpProblem& problem, const Pinhole& camera, uint64_t seed, int min_inliers) {
  constexpr int kTries = 300;
  constexpr double kConfidence = 0.99, kChi2 = 5.991;
  const size_t n = problem.points_w.size();
  if (n < 4) return std::nullopt;
  const auto agrees = [&](const SE3& T, size_t i) {
    const Eigen::Vector3d p = T * problem.points_w[i];
    if (!(p.z() > 0)) return false;
    const Eigen::Vector3d& ray = problem.rays[i];
    const double du = camera.fx * (p.x() / p.z() - ray.x()), dv = camera.fy * (p.y() / p.z() - ray.y());
    return du * du + dv * dv <= kChi2 * problem.sigma2[i];
  };
  Random random(seed);
  PnpResult best;
  int tries = kTries;
  std::array<SE3, 4> poses;
  for (int t = 0; t < tries; ++t) {
    std::array<size_t, 3> sample{};
    for (size_t k = 0; k < 3; ++k) {
      do {
        sample[k] = random.below(static_cast<uint32_t>(n));
      } while (std::find(sample.begin(), sample.begin() + static_cast<ptrdiff_t>(k), sample[k]) !=
               sample.begin() + static_cast<ptrdiff_t>(k));
    }
    const int count = solve_p3p({problem.points_w[sample[0]], problem.points_w[sample[1]], problem.points_w[sample[2]]},
                                {problem.rays[sample[0]], problem.rays[sample[1]], problem.rays[sample[2]]}, poses);
    for (int k = 0; k < count; ++k) {
      int inliers = 0;
      for (size_t i = 0; i < n; ++i) inliers += agrees(poses[static_cast<size_t>(k)], i);
      if (inliers <= best.inliers) continue;
      best.inliers = inliers;
      best.T_cw = poses[static_cast<size_t>(k)];
      const double share = static_cast<double>(inliers) / static_cast<double>(n);
      const double miss = std::log(std::max(1e-12, 1 - share * share * share));
      // With three inliers of thousands the quotient is beyond an int.
      if (miss < 0) tries = static_cast<int>(std::min<double>(kTries, std::ceil(std::log(1 - kConfidence) / miss)));
    }
  }
  if (best.inliers < min_inliers) return std::nullopt;
  best.inlier.resize(n);
  for (size_t i = 0; i < n; ++i) best.inlier[i] = agrees(best.T_cw, i);
  return best;
}

}  // namespace covis
