// SPDX-License-Identifier: Apache-2.0
#include "covis/optimization/pose_graph.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "covis/core/aligned.h"
#include "covis/optimization/block_system.h"

namespace covis {
namespace {

// J_l(e)^-1 = ad / (exp(ad) - 1) with ad = ad(e), by its series, the sum of B_2k ad^2k / (2k)! with the Bernoulli
// numbers B. It converges as (r / 2 pi)^2k, r being the greatest eigenvalue, and residuals are mostly small.
Matrix7d inverse_left_jacobian(const Vector7d& e) {
  const Eigen::Vector3d rho = e.head<3>(), phi = e.segment<3>(3);
  if (!(phi.squaredNorm() + e(6) * e(6) < 0.25)) return Sim3::left_jacobian(e).partialPivLu().inverse();
  Matrix7d ad = Matrix7d::Zero();  // ad(e) * d = [e, d]
  ad.topLeftCorner<3, 3>() = ad.block<3, 3>(3, 3) = hat(phi);
  ad.topLeftCorner<3, 3>().diagonal().array() += e(6);
  ad.block<3, 3>(0, 3) = hat(rho);
  ad.topRightCorner<3, 1>() = -rho;
  constexpr double kCoefficients[] = {1.0,
                                      1.0 / 12,
                                      -1.0 / 720,
                                      1.0 / 30240,
                                      -1.0 / 1209600,
                                      1.0 / 47900160.0,
                                      -691.0 / 1307674368000.0,
                                      1.0 / 74724249600.0};
  const Matrix7d squared = ad * ad;
  Matrix7d sum = kCoefficients[7] * Matrix7d::Identity();
  for (int k = 6; k >= 0; --k) {
    sum = (squared * sum).eval();
    sum.diagonal().array() += kCoefficients[k];
  }
  return sum - 0.5 * ad;
}

}  // namespace

Vector7d pose_graph_residual(const Sim3& S_ji, const Sim3& S_iw, const Sim3& S_jw) {
  return (S_ji * S_iw * S_jw.inverse()).log();
}

// With E = S_ji S_i S_j^-1:  S_ji exp(d_i) S_i S_j^-1 = exp(Adj(S_ji) d_i) E,  S_ji S_i (exp(d_j) S_j)^-1 =
// E exp(-d_j) = exp(-Adj(E) d_j) E,  and log(exp(d) E) = e + J_l(e)^-1 d.
Vector7d pose_graph_residual(const Sim3& S_ji, const Sim3& S_iw, const Sim3& S_jw, Matrix7d& J_i, Matrix7d& J_j) {
  const Sim3 E = S_ji * S_iw * S_jw.inverse();
  const Vector7d e = E.log();
  const Matrix7d J_l_inverse = inverse_left_jacobian(e);
  J_i.noalias() = J_l_inverse * S_ji.adjoint();
  J_j.noalias() = -J_l_inverse * E.adjoint();
  return e;
}

namespace {

// N is 7, or 6 without scale (without the last row of every residual and the last column of every Jacobian).
template <int N>
class PoseGraphSolver {
 public:
  explicit PoseGraphSolver(PoseGraphProblem& problem) : problem_(problem) { prepare(); }
  PoseGraphSummary run(const PoseGraphOptions& options);

 private:
  using Block = Eigen::Matrix<double, N, N>;
  using Vector = Eigen::Matrix<double, N, 1>;

  void prepare();
  double cost(const std::vector<Sim3>& poses) const;
  void linearise();
  bool solve_step(double lambda);
  double take_step(double lambda);  // writes try_; returns the gain predicted by the linear model

  int32_t free_of(int32_t pose) const { return free_pose_[static_cast<size_t>(pose)]; }

  PoseGraphProblem& problem_;
  std::vector<int32_t> free_pose_;   // number of each pose among those that move, or -1
  std::vector<int32_t> free_index_;  // poses that move, in the order of elimination
  std::vector<uint32_t> slot_;       // block in system_ of each edge between poses that move
  BlockSystem<N> system_;
  AlignedVector<Block> H_;  // diagonal blocks of the normal equations, before damping
  Eigen::VectorXd b_, step_;
  std::vector<Sim3> try_;
};

template <int N>
void PoseGraphSolver<N>::prepare() {
  free_pose_.assign(problem_.poses.size(), -1);
  std::vector<uint8_t> held(problem_.poses.size(), 0);
  for (const PoseGraphEdge& edge : problem_.edges)
    held[static_cast<size_t>(edge.i)] = held[static_cast<size_t>(edge.j)] = 1;
  std::vector<int32_t> moving;
  for (size_t c = 0; c < held.size(); ++c) {
    if (problem_.fixed[c] || !held[c]) continue;
    free_pose_[c] = static_cast<int32_t>(moving.size());
    moving.push_back(static_cast<int32_t>(c));
  }
  const auto collect = [&](std::vector<BlockPair>& pairs) {
    pairs.clear();
    for (const PoseGraphEdge& edge : problem_.edges) {
      const int32_t i = free_of(edge.i), j = free_of(edge.j);
      if (i >= 0 && j >= 0) pairs.push_back(make_block_pair(i, j));
    }
  };
  const auto variables = static_cast<int32_t>(moving.size());
  std::vector<BlockPair> pairs;
  collect(pairs);
  const std::vector<int32_t> order = sparse_order(variables, pairs);
  free_index_.resize(moving.size());
  for (size_t k = 0; k < order.size(); ++k) {
    free_index_[k] = moving[static_cast<size_t>(order[k])];
    free_pose_[static_cast<size_t>(free_index_[k])] = static_cast<int32_t>(k);
  }
  collect(pairs);
  make_unique(pairs);
  system_.set_pattern(variables, pairs);
  slot_.clear();
  for (const PoseGraphEdge& edge : problem_.edges) {
    const int32_t i = free_of(edge.i), j = free_of(edge.j);
    slot_.push_back(i >= 0 && j >= 0 ? system_.slot(make_block_pair(i, j)) : 0);
  }
}

template <int N>
double PoseGraphSolver<N>::cost(const std::vector<Sim3>& poses) const {
  double total = 0;
  for (const PoseGraphEdge& edge : problem_.edges) {
    const Vector7d e =
        pose_graph_residual(edge.S_ji, poses[static_cast<size_t>(edge.i)], poses[static_cast<size_t>(edge.j)]);
    total += edge.weight * e.template head<N>().squaredNorm();
  }
  return total;
}

template <int N>
void PoseGraphSolver<N>::linearise() {
  H_.assign(free_index_.size(), Block::Zero());
  b_.setZero(static_cast<Eigen::Index>(free_index_.size()) * N);
  system_.set_zero();
  Matrix7d J_i, J_j;
  for (size_t k = 0; k < problem_.edges.size(); ++k) {
    const PoseGraphEdge& edge = problem_.edges[k];
    const int32_t i = free_of(edge.i), j = free_of(edge.j);
    if (i < 0 && j < 0) continue;
    const Vector e = pose_graph_residual(edge.S_ji, problem_.poses[static_cast<size_t>(edge.i)],
                                         problem_.poses[static_cast<size_t>(edge.j)], J_i, J_j)
                         .template head<N>();
    const Block A = J_i.template topLeftCorner<N, N>(), B = J_j.template topLeftCorner<N, N>();
    const double w = edge.weight;
    if (i >= 0) {
      H_[static_cast<size_t>(i)].noalias() += w * (A.transpose() * A);
      b_.segment<N>(i * N).noalias() -= w * (A.transpose() * e);
    }
    if (j >= 0) {
      H_[static_cast<size_t>(j)].noalias() += w * (B.transpose() * B);
      b_.segment<N>(j * N).noalias() -= w * (B.transpose() * e);
    }
    if (i < 0 || j < 0) continue;
    if (i < j) {
      system_.block(slot_[k]).noalias() += w * (A.transpose() * B);
    } else {
      system_.block(slot_[k]).noalias() += w * (B.transpose() * A);
    }
  }
}

template <int N>
bool PoseGraphSolver<N>::solve_step(double lambda) {
  for (size_t c = 0; c < H_.size(); ++c) {
    Block damped = H_[c];
    damped.diagonal() += lambda * (H_[c].diagonal().array() + 1e-9).matrix();
    system_.diagonal(c) = damped;
  }
  return system_.solve(b_, step_);
}

template <int N>
double PoseGraphSolver<N>::take_step(double lambda) {
  try_ = problem_.poses;
  double gain = 0;
  for (size_t c = 0; c < free_index_.size(); ++c) {
    const auto at = static_cast<Eigen::Index>(c) * N;
    const Vector step = step_.segment<N>(at);
    gain += step.dot(lambda * H_[c].diagonal().cwiseProduct(step) + b_.segment<N>(at));
    Vector7d xi = Vector7d::Zero();
    xi.head<N>() = step;
    Sim3& S = try_[static_cast<size_t>(free_index_[c])];
    S = (Sim3::exp(xi) * S).normalized();
  }
  return gain;
}

template <int N>
PoseGraphSummary PoseGraphSolver<N>::run(const PoseGraphOptions& options) {
  PoseGraphSummary summary;
  double current = cost(problem_.poses);
  summary.initial_cost = summary.final_cost = current;
  if (free_index_.empty() || !std::isfinite(current)) {
    summary.ok = false;
    return summary;
  }
  linearise();
  double lambda = 1e-4, growth = 2;
  bool stepped = false;
  for (; summary.iterations < options.iterations && lambda < 1e12; ++summary.iterations) {
    double next = std::numeric_limits<double>::infinity(), gain = 1;
    if (solve_step(lambda)) {
      gain = take_step(lambda);
      next = cost(try_);
    }
    if (!(next <= current)) {
      lambda *= growth;
      growth *= 2;
      continue;
    }
    std::swap(problem_.poses, try_);
    stepped = true;
    const double r = 2 * (current - next) / std::max(gain, 1e-300) - 1;
    lambda = std::max(1e-12, lambda * std::clamp(1 - r * r * r, 1.0 / 3, 2.0));
    growth = 2;
    const bool done = current - next <= options.relative_cost_change * current;
    summary.final_cost = current = next;
    if (done) {
      ++summary.iterations;
      break;
    }
    linearise();
  }
  summary.ok = stepped || current < 1e-12;
  return summary;
}

}  // namespace

PoseGraphSummary optimize_pose_graph(PoseGraphProblem& problem, const PoseGraphOptions& options) {
  return problem.fix_scale ? PoseGraphSolver<6>(problem).run(options) : PoseGraphSolver<7>(problem).run(options);
}

}  // namespace covis
