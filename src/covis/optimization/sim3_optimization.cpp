// SPDX-License-Identifier: Apache-2.0
#include "covis/optimization/sim3_optimization.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>

#include "covis/core/random.h"
#include "covis/optimization/reprojection.h"

namespace covis {

namespace {

// Evaluates z - h, and d h / d xi for S <- exp(xi) S. Returns false when the point is behind the camera or not finite.
bool carried_residual(const Sim3& S, const Sim3& S_inverse, const CarriedPoint& point, const Pinhole& camera,
                      Eigen::Vector2d& e, Eigen::Matrix<double, 2, 7>* J = nullptr) {
  const bool forth = point.way == CarriedPoint::Way::forth;
  const Eigen::Vector3d carried = (forth ? S : S_inverse) * point.p;
  const Eigen::Vector3d p_view = point.T * carried;
  if (!(p_view.z() > kMinDepth)) return false;
  e = point.z - camera.project(p_view);
  if (!e.allFinite()) return false;
  if (!J) return true;
  // exp(xi) p = p + rho + phi x p + sigma p to first order; S^-1 exp(-xi) p_b has the opposite sign inside S^-1.
  Eigen::Matrix<double, 2, 3> J_b = projection_jacobian(p_view, camera, {}).topRows<2>() * point.T.R();
  if (!forth) J_b = J_b * (-S_inverse.scale() * S_inverse.R());
  const Eigen::Vector3d& p_b = forth ? carried : point.p;
  *J << J_b, -J_b * hat(p_b), J_b * p_b;
  return true;
}

// sim3_residual(), with the inverse of S_12 made once for many matches.
bool pair_residual(const Sim3& S_12, const Sim3& S_21, const Sim3Match& match, const Pinhole& camera_1,
                   const Pinhole& camera_2, Eigen::Vector4d& e, Eigen::Matrix<double, 4, 7>* J = nullptr) {
  // Each camera is the only view of its map, and its frame of reference.
  const auto half = [&](CarriedPoint::Way way, const Eigen::Vector3d& p, const Eigen::Vector2d& z,
                        const Pinhole& camera, int row) {
    Eigen::Vector2d e_half;
    Eigen::Matrix<double, 2, 7> J_half;
    if (!carried_residual(S_12, S_21, {way, p, SE3(), z}, camera, e_half, J ? &J_half : nullptr)) return false;
    e.segment<2>(row) = e_half;
    if (J) J->middleRows<2>(row) = J_half;
    return true;
  };
  return half(CarriedPoint::Way::forth, match.p_2, match.z_1, camera_1, 0) &&
         half(CarriedPoint::Way::back, match.p_1, match.z_2, camera_2, 2);
}

// Matches of two cameras.
struct Pairs {
  std::span<const Sim3Match> matches;
  const Pinhole& camera_1;
  const Pinhole& camera_2;
  bool fix_scale;
};

struct Sim3System {
  Matrix7d H = Matrix7d::Zero();
  Vector7d b = Vector7d::Zero();
  double cost = 0;
  int used = 0;
};

// Sums over the matches with use[i] != 0; a bound of 0 disables Huber's rho.
Sim3System accumulate(const Sim3& S_12, const Pairs& pairs, const std::vector<uint8_t>& use, double huber_bound) {
  Sim3System s;
  const Sim3 S_21 = S_12.inverse();
  Eigen::Vector4d e;
  Eigen::Matrix<double, 4, 7> J;
  for (size_t i = 0; i < pairs.matches.size(); ++i) {
    const Sim3Match& match = pairs.matches[i];
    if (!use[i] || !pair_residual(S_12, S_21, match, pairs.camera_1, pairs.camera_2, e, &J)) continue;
    ++s.used;
    if (pairs.fix_scale) J.col(6).setZero();
    Eigen::Vector4d w;
    const auto weigh = [&](int row, double inv_sigma2) {
      const double chi2 = e.segment<2>(row).squaredNorm() * inv_sigma2;
      double weight = 1;
      s.cost += huber_bound > 0 ? huber(chi2, huber_bound, weight) : chi2;
      w.segment<2>(row).setConstant(weight * inv_sigma2);
    };
    weigh(0, match.inv_sigma2_1);
    weigh(2, match.inv_sigma2_2);
    s.H.noalias() += J.transpose() * (w.asDiagonal() * J);
    s.b.noalias() += J.transpose() * w.cwiseProduct(e);
  }
  if (pairs.fix_scale) s.H(6, 6) = 1;  // makes the step of the scale 0
  return s;
}

// Views of two maps.
struct Views {
  std::span<const CarriedPoint> points;
  const Pinhole& camera;
  Scale scale;
};

Sim3System accumulate(const Sim3& S, const Views& views, const std::vector<uint8_t>& use, double huber_bound) {
  Sim3System s;
  const Sim3 S_inverse = S.inverse();
  Eigen::Vector2d e;
  Eigen::Matrix<double, 2, 7> J;
  for (size_t i = 0; i < views.points.size(); ++i) {
    const CarriedPoint& point = views.points[i];
    if (!use[i] || !carried_residual(S, S_inverse, point, views.camera, e, &J)) continue;
    ++s.used;
    if (views.scale == Scale::fixed) J.col(6).setZero();
    const double chi2 = e.squaredNorm() * point.inv_sigma2;
    double weight = 1;
    s.cost += huber_bound > 0 ? huber(chi2, huber_bound, weight) : chi2;
    s.H.noalias() += weight * point.inv_sigma2 * (J.transpose() * J);
    s.b.noalias() += weight * point.inv_sigma2 * (J.transpose() * e);
  }
  if (views.scale == Scale::fixed) s.H(6, 6) = 1;  // makes the step of the scale 0
  return s;
}

// `Problem`: Pairs or Views. Returns false for too few matches or a system without a solution.
template <class Problem>
bool descend(Sim3& S_12, const Problem& problem, const std::vector<uint8_t>& use, double huber_bound, int iterations) {
  double lambda = 1e-6;
  Sim3System s = accumulate(S_12, problem, use, huber_bound);
  for (int k = 0; k < iterations; ++k) {
    if (s.used < 3) return false;
    Matrix7d H = s.H;
    H.diagonal() *= 1 + lambda;
    const Vector7d step = H.ldlt().solve(s.b);
    if (!step.allFinite()) return false;
    const Sim3 candidate = Sim3::exp(step) * S_12;
    const Sim3System next = accumulate(candidate, problem, use, huber_bound);
    // A step must not gain by moving points behind a camera.
    if (candidate.all_finite() && next.used >= s.used && next.cost <= s.cost) {
      S_12 = candidate;
      s = next;
      lambda = std::max(lambda * 0.1, 1e-9);
    } else {
      lambda = std::max(lambda * 10, 1e-4);
    }
  }
  S_12 = S_12.normalized();
  return true;
}

int classify(const Sim3& S_12, const Pairs& pairs, double max_chi2, std::vector<uint8_t>& inlier) {
  int count = 0;
  const Sim3 S_21 = S_12.inverse();
  Eigen::Vector4d e;
  for (size_t i = 0; i < inlier.size(); ++i) {
    const Sim3Match& match = pairs.matches[i];
    inlier[i] = pair_residual(S_12, S_21, match, pairs.camera_1, pairs.camera_2, e) &&
                e.head<2>().squaredNorm() * match.inv_sigma2_1 <= max_chi2 &&
                e.tail<2>().squaredNorm() * match.inv_sigma2_2 <= max_chi2;
    count += inlier[i];
  }
  return count;
}

int classify(const Sim3& S, const Views& views, std::vector<uint8_t>& agrees) {
  const Sim3 S_inverse = S.inverse();
  int count = 0;
  Eigen::Vector2d e;
  for (size_t i = 0; i < agrees.size(); ++i) {
    agrees[i] = carried_residual(S, S_inverse, views.points[i], views.camera, e) &&
                e.squaredNorm() * views.points[i].inv_sigma2 <= kRefineChi2;
    count += agrees[i];
  }
  return count;
}

std::optional<Sim3> closed_form(const std::vector<Eigen::Vector3d>& from, const std::vector<Eigen::Vector3d>& to,
                                Scale scale) {
  const std::optional<Alignment> alignment = align(from, to, scale);
  if (!alignment || !alignment->unique) return std::nullopt;
  const Sim3 S(alignment->T_ba, alignment->scale);
  return S.all_finite() ? std::optional(S) : std::nullopt;
}

std::array<uint32_t, 3> draw_three(Random& random, uint32_t n) {
  std::array<uint32_t, 3> drawn{random.below(n), random.below(n - 1), random.below(n - 2)};
  // Each number skips those drawn before it.
  drawn[1] += drawn[1] >= drawn[0];
  const auto [low, high] = std::minmax(drawn[0], drawn[1]);
  drawn[2] += drawn[2] >= low;
  drawn[2] += drawn[2] >= high;
  return drawn;
}

// Number of samples of 3 after which one is all inliers with a probability of 99 %.
double samples_needed(double inlier_share) {
  const double good = inlier_share * inlier_share * inlier_share;
  return good >= 1 ? 1 : std::log(0.01) / std::log1p(-good);
}

}  // namespace

bool sim3_residual(const Sim3& S_12, const Sim3Match& match, const Pinhole& camera_1, const Pinhole& camera_2,
                   Eigen::Vector4d& e, Eigen::Matrix<double, 4, 7>* J) {
  return pair_residual(S_12, S_12.inverse(), match, camera_1, camera_2, e, J);
}

Sim3Result refine_sim3(const Sim3& S_12, std::span<const Sim3Match> matches, const Pinhole& camera_1,
                       const Pinhole& camera_2, bool fix_scale, double max_chi2) {
  const Pairs pairs{matches, camera_1, camera_2, fix_scale};
  Sim3Result result;
  result.S_12 = S_12;
  result.inlier.assign(matches.size(), 1);
  Sim3 S = S_12;
  if (!descend(S, pairs, result.inlier, max_chi2, 5)) return result;
  const bool dropped = classify(S, pairs, max_chi2, result.inlier) < static_cast<int>(matches.size());
  if (!descend(S, pairs, result.inlier, 0, dropped ? 10 : 5)) return result;
  result.inliers = classify(S, pairs, max_chi2, result.inlier);
  if (result.inliers < 3) return result;
  result.S_12 = S;
  result.cost = accumulate(S, pairs, result.inlier, 0).cost;
  result.ok = true;
  return result;
}

CarriedResult refine_sim3(const Sim3& S, std::span<const CarriedPoint> points, const Pinhole& camera, Scale scale) {
  const Views views{points, camera, scale};
  std::vector<uint8_t> agrees(points.size(), 1);
  Sim3 refined = S;
  if (!descend(refined, views, agrees, kRefineChi2, 5)) return {S};
  classify(refined, views, agrees);
  if (!descend(refined, views, agrees, 0, 10)) return {S};
  const int count = classify(refined, views, agrees);
  if (count < 3) return {S};
  return {refined, count, true, accumulate(refined, views, agrees, 0).H};
}

std::optional<Sim3Result> ransac_sim3(std::span<const Sim3Match> matches, const Pinhole& camera_1,
                                      const Pinhole& camera_2, bool fix_scale, uint64_t seed, int min_inliers) {
  constexpr int kTries = 300;
  const auto n = static_cast<uint32_t>(matches.size());
  if (n < 3 || static_cast<int>(n) < min_inliers) return std::nullopt;
  const Pairs pairs{matches, camera_1, camera_2, fix_scale};
  Random random(seed);
  Sim3Result best;
  std::vector<uint8_t> inlier(n);
  std::vector<Eigen::Vector3d> from, to;
  const auto consider = [&] {
    const std::optional<Sim3> S = closed_form(from, to, fix_scale ? Scale::fixed : Scale::free);
    if (!S) return;
    const int count = classify(*S, pairs, kRansacChi2, inlier);
    if (count <= best.inliers) return;
    best.S_12 = *S;
    best.inliers = count;
    best.inlier = inlier;
  };
  double needed = kTries;
  for (int tries = 0; tries < std::min<double>(needed, kTries); ++tries) {
    from.clear();
    to.clear();
    for (const uint32_t k : draw_three(random, n)) {
      from.push_back(matches[k].p_2);
      to.push_back(matches[k].p_1);
    }
    consider();
    if (best.inliers > 0) needed = samples_needed(static_cast<double>(best.inliers) / n);
  }
  if (best.inliers < 3) return std::nullopt;
  from.clear();
  to.clear();
  for (size_t k = 0; k < n; ++k) {
    if (!best.inlier[k]) continue;
    from.push_back(matches[k].p_2);
    to.push_back(matches[k].p_1);
  }
  consider();  // replaces the model when it has more inliers
  if (best.inliers < min_inliers) return std::nullopt;
  best.cost = accumulate(best.S_12, pairs, best.inlier, 0).cost;
  best.ok = true;
  return best;
}

}  // namespace covis
