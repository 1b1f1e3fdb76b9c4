// SPDX-License-Identifier: Apache-2.0
#include "covis/optimization/bundle_adjustment.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <Eigen/SparseCholesky>

#include "covis/core/aligned.h"
#include "covis/optimization/pose_optimization.h"
#include "covis/optimization/reprojection.h"

namespace covis {
namespace {

using Matrix6x3d = Eigen::Matrix<double, 6, 3>;

// Above this many free poses the reduced system is kept sparse.
constexpr int kDensePoses = 64;

double bound_of(const BundleObservation& o) { return o.u_right >= 0 ? kChi2Stereo : kChi2Mono; }

bool stopped(const BundleOptions& options) { return options.interrupt && options.interrupt->load(std::memory_order_relaxed); }

}  // namespace

// With e = z - h, J_c and J_p the Jacobians of h, and weights W, one Gauss-Newton step solves
//
//   [ U   W ] [dx_c]   [ b_c ]      U = sum J_c' W J_c,  V = sum J_p' W J_p (3x3 blocks),
//   [ W'  V ] [dx_p] = [ b_p ]      W_cp = J_c' W J_p,   b = J' W e;
//
// eliminating points: (U - W V^-1 W') dx_c = b_c - W V^-1 b_p, then dx_p = V^-1 (b_p - W' dx_c).
struct BundleAdjuster::Workspace {
  // Observations sorted by point; those of point p are [offset[p], offset[p + 1]).
  std::vector<uint32_t> offset;
  std::vector<BundleObservation> sorted;
  std::vector<int32_t> free_pose;  // for each pose its index among the free ones, or -1
  std::vector<int32_t> free_index;  // poses that move
  std::vector<uint8_t> point_moves;

  AlignedVector<Matrix6d> U;
  AlignedVector<Vector6d> b_c;
  AlignedVector<Eigen::Matrix3d> V, V_inv;
  AlignedVector<Eigen::Vector3d> b_p;
  AlignedVector<Matrix6x3d> W;  // for each sorted observation of a free pose
  std::vector<uint8_t> used;    // for each sorted observation

  Eigen::MatrixXd S;
  Eigen::VectorXd rhs, step_c;
  AlignedVector<Eigen::Vector3d> step_p;
  std::vector<SE3> poses_try;
  std::vector<Eigen::Vector3d> points_try;
  std::vector<std::pair<int32_t, Matrix6x3d>> row;  // W V^-1 of one point

  Eigen::SparseMatrix<double> sparse;
  Eigen::SimplicialLLT<Eigen::SparseMatrix<double>> sparse_solver;
  bool pattern_known = false;

  void prepare(const BundleProblem& problem);
  double cost(const BundleProblem& problem, const std::vector<SE3>& poses, const std::vector<Eigen::Vector3d>& points,
              bool robust) const;
  double linearise(const BundleProblem& problem, bool robust);
  bool solve_step(double lambda);
  bool solve_reduced();
};

void BundleAdjuster::Workspace::prepare(const BundleProblem& problem) {
  const size_t points = problem.points.size();
  offset.assign(points + 1, 0);
  for (const BundleObservation& o : problem.observations) {
    if (o.active) ++offset[static_cast<size_t>(o.point) + 1];
  }
  for (size_t p = 0; p < points; ++p) offset[p + 1] += offset[p];
  sorted.resize(offset[points]);
  std::vector<uint32_t> next(offset.begin(), offset.end() - 1);
  for (const BundleObservation& o : problem.observations) {
    if (o.active) sorted[next[static_cast<size_t>(o.point)]++] = o;
  }
  std::vector<uint32_t> seen(problem.poses.size(), 0);
  point_moves.assign(points, 0);
  for (size_t p = 0; p < points; ++p) {
    uint32_t rows = 0;
    for (uint32_t k = offset[p]; k < offset[p + 1]; ++k) {
      rows += sorted[k].u_right >= 0 ? 3 : 2;
      ++seen[static_cast<size_t>(sorted[k].pose)];
    }
    point_moves[p] = rows >= 3;  // fewer leave it undetermined: it stays
  }
  free_pose.assign(problem.poses.size(), -1);
  free_index.clear();
  for (size_t c = 0; c < problem.poses.size(); ++c) {
    if (problem.fixed[c] || seen[c] == 0) continue;
    free_pose[c] = static_cast<int32_t>(free_index.size());
    free_index.push_back(static_cast<int32_t>(c));
  }
  pattern_known = false;
}

double BundleAdjuster::Workspace::cost(const BundleProblem& problem, const std::vector<SE3>& poses,
                                       const std::vector<Eigen::Vector3d>& points, bool robust) const {
  double total = 0;
  for (size_t k = 0; k < sorted.size(); ++k) {
    const BundleObservation& o = sorted[k];
    const Eigen::Vector3d p_c = poses[static_cast<size_t>(o.pose)] * points[static_cast<size_t>(o.point)];
    if (!(p_c.z() > kMinDepth)) {
      if (used[k]) return std::numeric_limits<double>::infinity();  // a step may not take a point behind a camera
      continue;
    }
    const Eigen::Vector3d e = reprojection_residual(p_c, problem.camera, o.u, o.v, o.u_right);
    const double chi2 = e.squaredNorm() * o.inv_sigma2;
    double weight;
    if (used[k]) total += robust ? huber(chi2, bound_of(o), weight) : chi2;
  }
  return total;
}

double BundleAdjuster::Workspace::linearise(const BundleProblem& problem, bool robust) {
  const size_t points = problem.points.size();
  U.assign(free_index.size(), Matrix6d::Zero());
  b_c.assign(free_index.size(), Vector6d::Zero());
  V.assign(points, Eigen::Matrix3d::Zero());
  b_p.assign(points, Eigen::Vector3d::Zero());
  W.resize(sorted.size());
  used.assign(sorted.size(), 0);
  double total = 0;
  for (size_t k = 0; k < sorted.size(); ++k) {
    const BundleObservation& o = sorted[k];
    const auto p = static_cast<size_t>(o.point);
    const SE3& T = problem.poses[static_cast<size_t>(o.pose)];
    const Eigen::Vector3d p_c = T * problem.points[p];
    if (!(p_c.z() > kMinDepth)) continue;
    used[k] = 1;
    const Eigen::Vector3d e = reprojection_residual(p_c, problem.camera, o.u, o.v, o.u_right);
    const double chi2 = e.squaredNorm() * o.inv_sigma2;
    double weight = 1;
    total += robust ? huber(chi2, bound_of(o), weight) : chi2;
    weight *= o.inv_sigma2;
    const Eigen::Matrix3d J_pi = projection_jacobian(p_c, problem.camera, o.u_right >= 0);
    const Eigen::Matrix3d J_p = J_pi * T.R();
    const Eigen::Matrix3d wJ_p = weight * J_p;
    V[p].noalias() += J_p.transpose() * wJ_p;
    b_p[p].noalias() += wJ_p.transpose() * e;
    const int32_t c = free_pose[static_cast<size_t>(o.pose)];
    if (c < 0) continue;
    const Matrix3x6d J_c = pose_jacobian(J_pi, p_c);
    const Matrix3x6d wJ_c = weight * J_c;
    U[static_cast<size_t>(c)].noalias() += J_c.transpose() * wJ_c;
    b_c[static_cast<size_t>(c)].noalias() += wJ_c.transpose() * e;
    W[k].noalias() = wJ_c.transpose() * J_p;
  }
  return total;
}

bool BundleAdjuster::Workspace::solve_step(double lambda) {
  const size_t points = V.size();
  const auto n = static_cast<Eigen::Index>(free_index.size()) * 6;
  S.setZero(n, n);
  rhs.resize(n);
  for (size_t c = 0; c < free_index.size(); ++c) {
    const auto at = static_cast<Eigen::Index>(c) * 6;
    Matrix6d block = U[c];
    block.diagonal() += lambda * (U[c].diagonal().array() + 1e-9).matrix();
    S.block<6, 6>(at, at) = block;
    rhs.segment<6>(at) = b_c[c];
  }
  V_inv.resize(points);
  for (size_t p = 0; p < points; ++p) {
    if (!point_moves[p]) continue;
    Eigen::Matrix3d v = V[p];
    v.diagonal() += lambda * (V[p].diagonal().array() + 1e-9).matrix();
    bool invertible = false;
    double determinant;
    v.computeInverseAndDetWithCheck(V_inv[p], determinant, invertible, 1e-30);
    if (!invertible || !V_inv[p].allFinite()) V_inv[p].setZero();
    row.clear();
    for (uint32_t k = offset[p]; k < offset[p + 1]; ++k) {
      const int32_t c = free_pose[static_cast<size_t>(sorted[k].pose)];
      if (c < 0 || !used[k]) continue;
      const Matrix6x3d Y = W[k] * V_inv[p];
      rhs.segment<6>(static_cast<Eigen::Index>(c) * 6).noalias() -= Y * b_p[p];
      row.emplace_back(static_cast<int32_t>(k), Y);
    }
    for (size_t i = 0; i < row.size(); ++i) {
      const auto ci = static_cast<Eigen::Index>(free_pose[static_cast<size_t>(sorted[static_cast<size_t>(row[i].first)].pose)]);
      for (size_t j = 0; j < row.size(); ++j) {
        const auto kj = static_cast<size_t>(row[j].first);
        const auto cj = static_cast<Eigen::Index>(free_pose[static_cast<size_t>(sorted[kj].pose)]);
        if (cj > ci) continue;  // the lower triangle is enough
        S.block<6, 6>(ci * 6, cj * 6).noalias() -= row[i].second * W[kj].transpose();
      }
    }
  }
  if (!solve_reduced()) return false;
  step_p.resize(points);
  for (size_t p = 0; p < points; ++p) {
    step_p[p].setZero();
    if (!point_moves[p]) continue;
    Eigen::Vector3d r = b_p[p];
    for (uint32_t k = offset[p]; k < offset[p + 1]; ++k) {
      const int32_t c = free_pose[static_cast<size_t>(sorted[k].pose)];
      if (c >= 0 && used[k]) r.noalias() -= W[k].transpose() * step_c.segment<6>(static_cast<Eigen::Index>(c) * 6);
    }
    step_p[p].noalias() = V_inv[p] * r;
  }
  return step_c.allFinite();
}

bool BundleAdjuster::Workspace::solve_reduced() {
  if (rhs.size() == 0) {
    step_c.resize(0);
    return true;
  }
  if (static_cast<int>(free_index.size()) <= kDensePoses) {
    const Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>, Eigen::Lower> llt(S);
    if (llt.info() != Eigen::Success) return false;
    step_c = llt.solve(rhs);
    return true;
  }
  sparse = S.triangularView<Eigen::Lower>().toDenseMatrix().sparseView();
  if (!pattern_known) {
    sparse_solver.analyzePattern(sparse);
    pattern_known = true;
  }
  sparse_solver.factorize(sparse);
  if (sparse_solver.info() != Eigen::Success) return false;
  step_c = sparse_solver.solve(rhs);
  return true;
}

BundleAdjuster::BundleAdjuster() : workspace_(std::make_unique<Workspace>()) {}
BundleAdjuster::~BundleAdjuster() = default;

BundleSummary BundleAdjuster::solve(BundleProblem& problem, const BundleOptions& options) {
  Workspace& w = *workspace_;
  BundleSummary summary;
  w.prepare(problem);
  if (w.sorted.empty()) {
    summary.ok = false;
    return summary;
  }
  double lambda = 1e-4, growth = 2;
  double cost = w.linearise(problem, options.robust);
  summary.initial_cost = summary.final_cost = cost;
  bool stepped = false;
  for (; summary.iterations < options.iterations; ++summary.iterations) {
    if (stopped(options)) {
      summary.interrupted = true;
      break;
    }
    if (!w.solve_step(lambda)) {
      lambda *= growth;
      growth *= 2;
      continue;
    }
    w.poses_try = problem.poses;
    w.points_try = problem.points;
    double gain = 0;  // what the linear model promises
    for (size_t c = 0; c < w.free_index.size(); ++c) {
      const auto pose = static_cast<size_t>(w.free_index[c]);
      const Vector6d step = w.step_c.segment<6>(static_cast<Eigen::Index>(c) * 6);
      gain += step.dot(lambda * w.U[c].diagonal().cwiseProduct(step) + w.b_c[c]);
      w.poses_try[pose] = SE3::exp(step) * problem.poses[pose];
    }
    for (size_t p = 0; p < w.points_try.size(); ++p) {
      gain += w.step_p[p].dot(lambda * w.V[p].diagonal().cwiseProduct(w.step_p[p]) + w.b_p[p]);
      w.points_try[p] += w.step_p[p];
    }
    const double next = w.cost(problem, w.poses_try, w.points_try, options.robust);
    const double ratio = (cost - next) / std::max(gain, 1e-300);
    if (std::isfinite(next) && next <= cost) {
      std::swap(problem.poses, w.poses_try);
      std::swap(problem.points, w.points_try);
      const bool done = cost - next <= options.relative_cost_change * cost;
      stepped = true;
      const double r = 2 * ratio - 1;
      lambda = std::max(1e-12, lambda * std::clamp(1 - r * r * r, 1.0 / 3, 2.0));
      growth = 2;
      summary.final_cost = cost = next;
      if (done) {
        ++summary.iterations;
        break;
      }
      cost = w.linearise(problem, options.robust);
    } else {
      lambda *= growth;
      growth *= 2;
      if (lambda > 1e12) break;
    }
  }
  for (const int32_t pose : w.free_index) {
    SE3& T = problem.poses[static_cast<size_t>(pose)];
    T = T.normalized();
  }
  summary.ok = stepped || summary.initial_cost < 1e-12 || summary.iterations > 0;
  return summary;
}

int classify_observations(BundleProblem& problem) {
  int inactive = 0;
  for (BundleObservation& o : problem.observations) {
    const Eigen::Vector3d p_c = problem.poses[static_cast<size_t>(o.pose)] * problem.points[static_cast<size_t>(o.point)];
    o.active = p_c.z() > kMinDepth &&
               reprojection_residual(p_c, problem.camera, o.u, o.v, o.u_right).squaredNorm() * o.inv_sigma2 <= bound_of(o);
    inactive += !o.active;
  }
  return inactive;
}

}  // namespace covis
