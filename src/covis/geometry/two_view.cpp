// SPDX-License-Identifier: Apache-2.0
#include "covis/geometry/two_view.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include "covis/core/random.h"
#include "covis/geometry/clearly_least.h"
#include "covis/geometry/triangulation.h"

namespace covis {
namespace {

constexpr double kChi2Homography = 5.991;   // bound for 2 degrees of freedom, 95 %
constexpr double kChi2Fundamental = 3.841;  // bound for 1 degree of freedom, 95 %
constexpr double kScoreCap = 5.991;         // used for both models, so that their scores are comparable

using Points = std::vector<Eigen::Vector2d>;

// Shifts and scales points to mean 0 and mean distance sqrt(2) (Hartley and Zisserman, 4.4.4).
Eigen::Matrix3d normalisation(const Points& points) {
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (const auto& p : points) mean += p;
  mean /= static_cast<double>(points.size());
  double distance = 0;
  for (const auto& p : points) distance += (p - mean).norm();
  const double s = std::numbers::sqrt2 * static_cast<double>(points.size()) / std::max(distance, 1e-9);
  Eigen::Matrix3d T;
  T << s, 0, -s * mean.x(), 0, s, -s * mean.y(), 0, 0, 1;
  return T;
}

using Matrix9d = Eigen::Matrix<double, 9, 9>;

Eigen::Matrix3d smallest(const Matrix9d& AtA) {
  const Eigen::SelfAdjointEigenSolver<Matrix9d> solver(AtA);
  const Eigen::Matrix<double, 9, 1> v = solver.eigenvectors().col(0);
  Eigen::Matrix3d m;
  m << v(0), v(1), v(2), v(3), v(4), v(5), v(6), v(7), v(8);
  return m;
}

// Fits H with b ~ H a to the given matches of normalised points.
Eigen::Matrix3d fit_homography(const Points& a, const Points& b, const std::vector<size_t>& use) {
  Matrix9d AtA = Matrix9d::Zero();
  for (const size_t i : use) {
    Eigen::Matrix<double, 2, 9> rows;
    const Eigen::Vector3d p = a[i].homogeneous();
    rows << Eigen::RowVector3d::Zero(), -p.transpose(), b[i].y() * p.transpose(),  //
        p.transpose(), Eigen::RowVector3d::Zero(), -b[i].x() * p.transpose();
    AtA += rows.transpose() * rows;
  }
  return smallest(AtA);
}

// Fits F with b' F a = 0, of rank 2.
Eigen::Matrix3d fit_fundamental(const Points& a, const Points& b, const std::vector<size_t>& use) {
  Matrix9d AtA = Matrix9d::Zero();
  for (const size_t i : use) {
    const Eigen::Vector3d p = a[i].homogeneous();
    Eigen::Matrix<double, 1, 9> row;
    row << b[i].x() * p.transpose(), b[i].y() * p.transpose(), p.transpose();
    AtA += row.transpose() * row;
  }
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(smallest(AtA), Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Vector3d w = svd.singularValues();
  w(2) = 0;
  return svd.matrixU() * w.asDiagonal() * svd.matrixV().transpose();
}

// Score of a model, truncated in both images (ORB-SLAM, eq. 2), and its inliers.
struct Score {
  double value = 0;
  std::vector<uint8_t> inlier;
  int count = 0;

  void add(size_t i, double chi2_a, double chi2_b, double bound) {
    const bool ok = chi2_a <= bound && chi2_b <= bound;
    if (chi2_a <= bound) value += kScoreCap - chi2_a;
    if (chi2_b <= bound) value += kScoreCap - chi2_b;
    inlier[i] = ok;
    count += ok;
  }
};

double sigma2_of(const TwoViewMatches& m, size_t i) { return m.sigma2.empty() ? 1.0 : m.sigma2[i]; }

Score score_homography(const Eigen::Matrix3d& H, const TwoViewMatches& m) {
  Score score;
  score.inlier.resize(m.a.size());
  const Eigen::Matrix3d inverse = H.inverse();
  for (size_t i = 0; i < m.a.size(); ++i) {
    const Eigen::Vector2d in_b = (H * m.a[i].homogeneous()).hnormalized(),
                          in_a = (inverse * m.b[i].homogeneous()).hnormalized();
    const double sigma2 = sigma2_of(m, i);
    score.add(i, (in_a - m.a[i]).squaredNorm() / sigma2, (in_b - m.b[i]).squaredNorm() / sigma2, kChi2Homography);
  }
  return score;
}

Score score_fundamental(const Eigen::Matrix3d& F, const TwoViewMatches& m) {
  Score score;
  score.inlier.resize(m.a.size());
  for (size_t i = 0; i < m.a.size(); ++i) {
    const Eigen::Vector3d a = m.a[i].homogeneous(), b = m.b[i].homogeneous();
    const Eigen::Vector3d line_b = F * a, line_a = F.transpose() * b;
    const double e = b.dot(line_b), e2 = e * e / sigma2_of(m, i);
    score.add(i, e2 / line_a.head<2>().squaredNorm(), e2 / line_b.head<2>().squaredNorm(), kChi2Fundamental);
  }
  return score;
}

std::vector<size_t> indices_of(const std::vector<uint8_t>& flags) {
  std::vector<size_t> indices;
  for (size_t i = 0; i < flags.size(); ++i) {
    if (flags[i]) indices.push_back(i);
  }
  return indices;
}

// The 8 motions of a homography of calibrated coordinates (Faugeras and Lustman), |t| = 1. Returns none when the
// singular values of the homography are not distinct.
std::vector<SE3> motions_of_homography(const Eigen::Matrix3d& H, const Eigen::Matrix3d& K) {
  const Eigen::Matrix3d A = K.inverse() * H * K;
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(A, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Eigen::Matrix3d U = svd.matrixU(), V = svd.matrixV();
  const double s = U.determinant() * V.determinant();
  const double d1 = svd.singularValues()(0), d2 = svd.singularValues()(1), d3 = svd.singularValues()(2);
  std::vector<SE3> motions;
  if (d1 / d2 < 1.00001 || d2 / d3 < 1.00001) return motions;
  const double x1 = std::sqrt((d1 * d1 - d2 * d2) / (d1 * d1 - d3 * d3)),
               x3 = std::sqrt((d2 * d2 - d3 * d3) / (d1 * d1 - d3 * d3));
  for (const double e1 : {1.0, -1.0}) {
    for (const double e3 : {1.0, -1.0}) {
      // the case d' = d2
      const double sin_t = e1 * e3 * std::sqrt((d1 * d1 - d2 * d2) * (d2 * d2 - d3 * d3)) / ((d1 + d3) * d2);
      const double cos_t = (d2 * d2 + d1 * d3) / ((d1 + d3) * d2);
      Eigen::Matrix3d R;
      R << cos_t, 0, -sin_t, 0, 1, 0, sin_t, 0, cos_t;
      const Eigen::Vector3d t = U * Eigen::Vector3d(e1 * x1, 0, -e3 * x3);
      motions.emplace_back(Eigen::Matrix3d(s * U * R * V.transpose()), t.normalized());
      // the case d' = -d2
      const double sin_p = e1 * e3 * std::sqrt((d1 * d1 - d2 * d2) * (d2 * d2 - d3 * d3)) / ((d1 - d3) * d2);
      const double cos_p = (d1 * d3 - d2 * d2) / ((d1 - d3) * d2);
      R << cos_p, 0, sin_p, 0, -1, 0, sin_p, 0, -cos_p;
      const Eigen::Vector3d t_p = U * Eigen::Vector3d(e1 * x1, 0, e3 * x3);
      motions.emplace_back(Eigen::Matrix3d(s * U * R * V.transpose()), t_p.normalized());
    }
  }
  return motions;
}

// The 4 motions of an essential matrix (Hartley and Zisserman, 9.6.2).
std::vector<SE3> motions_of_fundamental(const Eigen::Matrix3d& F, const Eigen::Matrix3d& K) {
  const Eigen::Matrix3d E = K.transpose() * F * K;
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(E, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Matrix3d W;
  W << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  Eigen::Matrix3d Ra = svd.matrixU() * W * svd.matrixV().transpose(),
                  Rb = svd.matrixU() * W.transpose() * svd.matrixV().transpose();
  if (Ra.determinant() < 0) Ra = -Ra;
  if (Rb.determinant() < 0) Rb = -Rb;
  const Eigen::Vector3d t = svd.matrixU().col(2);
  return {SE3(Ra, t), SE3(Rb, t), SE3(Ra, Eigen::Vector3d(-t)), SE3(Rb, Eigen::Vector3d(-t))};
}

constexpr double kMostExplainedChi2 = 4;  // of a match that a motion explains, in either image

// The point that a motion makes of a match, and how far it is off in the image where it is farther off.
struct MatchedPoint {
  Eigen::Vector3d p_1;
  double chi2 = 0;
  bool in_front = false;  // it is in front of both cameras
};

std::optional<MatchedPoint> point_of(const SE3& T_21, const TwoViewMatches& m, size_t i, const Pinhole& camera) {
  const auto p =
      triangulate(SE3(), camera.unproject(m.a[i].x(), m.a[i].y()), T_21, camera.unproject(m.b[i].x(), m.b[i].y()));
  if (!p || !p->allFinite()) return std::nullopt;
  const Eigen::Vector3d in_2 = T_21 * *p;
  if (p->z() == 0 || in_2.z() == 0) return std::nullopt;
  const double off_1 = (camera.project(*p) - m.a[i]).squaredNorm(),
               off_2 = (camera.project(in_2) - m.b[i]).squaredNorm();
  return MatchedPoint{*p, std::max(off_1, off_2) / sigma2_of(m, i), p->z() > 0 && in_2.z() > 0};
}

// Counts the inliers that a motion explains: in front of both cameras and with small residuals in both images. Those so
// far away that noise puts them behind the cameras speak for no motion, and against none.
TwoViewMotion try_motion(const SE3& T_21, const TwoViewMatches& m, const std::vector<uint8_t>& inlier,
                         const Pinhole& camera) {
  constexpr double kMinParallaxCos = 0.99998;  // points farther away give no parallax
  TwoViewMotion motion;
  motion.T_21 = T_21;
  motion.points_1.resize(m.a.size());
  motion.triangulated.assign(m.a.size(), 0);
  const Eigen::Vector3d centre_2 = T_21.centre();
  std::vector<double> cosines;
  for (size_t i = 0; i < m.a.size(); ++i) {
    if (!inlier[i]) continue;
    const auto point = point_of(T_21, m, i, camera);
    if (!point || point->chi2 > kMostExplainedChi2) continue;
    const Eigen::Vector3d& p = point->p_1;
    const double cosine = p.dot(p - centre_2) / (p.norm() * (p - centre_2).norm());
    const bool far = cosine >= kMinParallaxCos;
    if (!far && !point->in_front) continue;
    cosines.push_back(cosine);
    ++(point->in_front ? motion.explained : motion.behind);
    if (far) continue;
    motion.points_1[i] = p;
    motion.triangulated[i] = 1;
  }
  if (cosines.empty()) return motion;
  std::sort(cosines.begin(), cosines.end());
  const size_t at = std::min(std::max<size_t>(50, cosines.size() / 4), cosines.size() - 1);
  motion.parallax_deg = std::acos(std::clamp(cosines[at], -1.0, 1.0)) * 180 / std::numbers::pi;
  return motion;
}

// The index of the motion, of those of a plane, that explains what is not on the plane clearly better than the others
// do; nullopt if there is none.
std::optional<size_t> decided_off_the_plane(const std::vector<TwoViewMotion>& motions, const TwoViewMatches& m,
                                            const std::vector<uint8_t>& on_plane, const Pinhole& camera) {
  constexpr double kClearly = 2, kLeastMore = 60;  // squared sigmas in all
  std::vector<double> misfits(motions.size()), chi2(motions.size());
  for (size_t i = 0; i < m.a.size(); ++i) {
    if (on_plane[i]) continue;
    for (size_t k = 0; k < motions.size(); ++k) {
      const auto point = point_of(motions[k].T_21, m, i, camera);
      chi2[k] = point && point->in_front ? std::min(point->chi2, kMostExplainedChi2) : kMostExplainedChi2;
    }
    if (*std::min_element(chi2.begin(), chi2.end()) == kMostExplainedChi2) continue;  // a wrong match
    for (size_t k = 0; k < motions.size(); ++k) misfits[k] += chi2[k];
  }
  return clearly_least(misfits, kClearly, kLeastMore);
}

}  // namespace

TwoViewStatus TwoViewMotion::status(const TwoViewOptions& options) const {
  if (parallax_deg < options.min_parallax_deg) return TwoViewStatus::low_parallax;
  if (share < options.min_good_share) return TwoViewStatus::no_clear_winner;
  const auto points = std::count(triangulated.begin(), triangulated.end(), 1);
  return points < options.min_points ? TwoViewStatus::too_few_points : TwoViewStatus::ok;
}

TwoViewResult reconstruct_two_views(const TwoViewMatches& m, const Pinhole& camera, const TwoViewOptions& options) {
  TwoViewResult result;
  const size_t n = m.a.size();
  if (n < 8 || static_cast<int>(n) < options.min_points) return result;
  const Eigen::Matrix3d Ta = normalisation(m.a), Tb = normalisation(m.b);
  Points a(n), b(n);
  for (size_t i = 0; i < n; ++i) {
    a[i] = (Ta * m.a[i].homogeneous()).hnormalized();
    b[i] = (Tb * m.b[i].homogeneous()).hnormalized();
  }
  const auto homography = [&](const std::vector<size_t>& use) -> Eigen::Matrix3d {
    return Tb.inverse() * fit_homography(a, b, use) * Ta;
  };
  const auto fundamental = [&](const std::vector<size_t>& use) -> Eigen::Matrix3d {
    return Tb.transpose() * fit_fundamental(a, b, use) * Ta;
  };

  Random random(options.seed);
  Eigen::Matrix3d H = Eigen::Matrix3d::Identity(), F = Eigen::Matrix3d::Zero();
  Score score_h, score_f;
  std::vector<size_t> order(n), sample(8);
  for (size_t i = 0; i < n; ++i) order[i] = i;
  for (int t = 0; t < options.iterations; ++t) {
    for (size_t k = 0; k < 8; ++k) {
      std::swap(order[k], order[k + random.below(static_cast<uint32_t>(n - k))]);
      sample[k] = order[k];
    }
    const Eigen::Matrix3d h = homography(sample), f = fundamental(sample);
    Score sh = score_homography(h, m), sf = score_fundamental(f, m);
    if (sh.value > score_h.value) {
      score_h = std::move(sh);
      H = h;
    }
    if (sf.value > score_f.value) {
      score_f = std::move(sf);
      F = f;
    }
  }
  // Refits to all inliers as long as the score improves.
  for (int k = 0; k < 5 && score_h.count >= 8; ++k) {
    const Eigen::Matrix3d h = homography(indices_of(score_h.inlier));
    Score s = score_homography(h, m);
    if (s.value <= score_h.value) break;
    score_h = std::move(s);
    H = h;
  }
  for (int k = 0; k < 5 && score_f.count >= 8; ++k) {
    const Eigen::Matrix3d f = fundamental(indices_of(score_f.inlier));
    Score s = score_fundamental(f, m);
    if (s.value <= score_f.value) break;
    score_f = std::move(s);
    F = f;
  }
  result.score_h = score_h.value;
  result.score_f = score_f.value;
  result.status = TwoViewStatus::no_model;
  if (score_h.value + score_f.value <= 0) return result;
  result.homography = score_h.value / (score_h.value + score_f.value) > options.homography_ratio;
  const Score& score = result.homography ? score_h : score_f;
  if (score.count < options.min_points) return result;

  Eigen::Matrix3d K;
  K << camera.fx, 0, camera.cx, 0, camera.fy, camera.cy, 0, 0, 1;
  std::vector<TwoViewMotion>& motions = result.motions;
  for (const SE3& motion : result.homography ? motions_of_homography(H, K) : motions_of_fundamental(F, K))
    motions.push_back(try_motion(motion, m, score.inlier, camera));
  std::stable_sort(motions.begin(), motions.end(),
                   [](const TwoViewMotion& x, const TwoViewMotion& y) { return x.explained > y.explained; });
  const double rivals = options.clear_winner * (motions.empty() ? 0 : motions.front().explained);
  std::erase_if(motions, [&](const TwoViewMotion& motion) { return motion.explained <= rivals; });
  TwoViewOptions asked = options;
  if (result.homography && motions.size() > 1) {
    if (const auto right = decided_off_the_plane(motions, m, score.inlier, camera)) {
      std::swap(motions.front(), motions[*right]);
      motions.resize(1);
      asked.min_parallax_deg *= options.plane_parallax;
    }
  }
  for (TwoViewMotion& motion : motions)
    motion.share = (motion.explained + motion.behind) / static_cast<double>(score.count);
  const bool parallax = std::any_of(motions.begin(), motions.end(), [&](const TwoViewMotion& motion) {
    return motion.parallax_deg >= asked.min_parallax_deg;
  });
  result.status = !parallax            ? TwoViewStatus::low_parallax
                  : motions.size() > 1 ? TwoViewStatus::no_clear_winner
                                       : motions.front().status(asked);
  const bool are_rivals = parallax && result.homography && motions.size() > 1;
  if (result.status != TwoViewStatus::ok && !are_rivals) motions.clear();
  return result;
}

}  // namespace covis
