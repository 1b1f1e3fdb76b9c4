// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>

#include "covis/optimization/bundle_workspace.h"

namespace covis {

// Returns the pairs of free poses that observe a common point, sorted and unique.
std::vector<BlockPair> BundleAdjuster::Workspace::co_observing() const {
  // Indices of the observations, grouped by pose.
  std::vector<uint32_t> first(free_index.size() + 1, 0), by_pose(sorted.size());
  for (uint32_t k = 0; k < sorted.size(); ++k) {
    if (free_of(k) >= 0) ++first[static_cast<size_t>(free_of(k)) + 1];
  }
  for (size_t c = 0; c < free_index.size(); ++c) first[c + 1] += first[c];
  std::vector<uint32_t> next(first.begin(), first.end() - 1);
  for (uint32_t k = 0; k < sorted.size(); ++k) {
    if (free_of(k) >= 0) by_pose[next[static_cast<size_t>(free_of(k))]++] = k;
  }
  std::vector<BlockPair> pairs;
  std::vector<int32_t> met(free_index.size(), -1);
  for (int32_t c = 0; c < static_cast<int32_t>(free_index.size()); ++c) {
    const auto begin = static_cast<std::ptrdiff_t>(pairs.size());
    for (uint32_t o = first[static_cast<size_t>(c)]; o < first[static_cast<size_t>(c) + 1]; ++o) {
      const auto p = static_cast<size_t>(sorted[by_pose[o]].point);
      if (!point_moves[p]) continue;
      for (uint32_t k = offset[p]; k < offset[p + 1]; ++k) {
        const int32_t other = free_of(k);
        if (other < 0 || other >= c || met[static_cast<size_t>(other)] == c) continue;
        met[static_cast<size_t>(other)] = c;
        pairs.emplace_back(c, other);
      }
    }
    std::sort(pairs.begin() + begin, pairs.end());
  }
  return pairs;
}

// Renumbers the free poses in an order with little fill-in, and looks up the block of each pair of observations.
void BundleAdjuster::Workspace::prepare_sparse() {
  const auto variables = static_cast<int32_t>(free_index.size());
  std::vector<BlockPair> pairs = co_observing();
  const std::vector<int32_t> order = sparse_order(variables, pairs);
  std::vector<int32_t> renumbered(order.size()), poses(order.size());
  for (size_t k = 0; k < order.size(); ++k) {
    const auto before = static_cast<size_t>(order[k]);
    renumbered[before] = static_cast<int32_t>(k);
    poses[k] = free_index[before];
    free_pose[static_cast<size_t>(poses[k])] = static_cast<int32_t>(k);
  }
  free_index = std::move(poses);
  for (BlockPair& pair : pairs) {
    pair = make_block_pair(renumbered[static_cast<size_t>(pair.first)], renumbered[static_cast<size_t>(pair.second)]);
  }
  make_unique(pairs);
  system.set_pattern(variables, pairs);
  slot.clear();
  for (size_t p = 0; p < point_moves.size(); ++p) {
    if (!point_moves[p]) continue;
    for (uint32_t i = offset[p]; i < offset[p + 1]; ++i) {
      for (uint32_t j = offset[p]; j < i; ++j) {
        const int32_t a = free_of(i), b = free_of(j);
        if (a >= 0 && b >= 0) slot.push_back(a == b ? 0 : system.slot(make_block_pair(a, b)));
      }
    }
  }
}

// Computes the damped U, and b_c.
void BundleAdjuster::Workspace::start_reduced(double lambda) {
  const auto n = static_cast<Eigen::Index>(free_index.size()) * 6;
  if (sparse) {
    system.set_zero();
  } else {
    S.setZero(n, n);
  }
  rhs.resize(n);
  for (size_t c = 0; c < free_index.size(); ++c) {
    const auto at = static_cast<Eigen::Index>(c) * 6;
    Matrix6d block = U[c];
    block.diagonal() += lambda * (U[c].diagonal().array() + 1e-9).matrix();
    if (sparse) {
      system.diagonal(c) = block;
    } else {
      S.block<6, 6>(at, at) = block;
    }
    rhs.segment<6>(at) = b_c[c];
  }
}

void BundleAdjuster::Workspace::add_sparse(size_t& next_slot) {
  for (size_t i = 0; i < row.size(); ++i) {
    const PoseOfPoint& a = row[i];
    system.diagonal(static_cast<size_t>(a.pose)).noalias() -= a.Y * a.W->transpose();
    for (size_t j = 0; j < i; ++j, ++next_slot) {
      const PoseOfPoint& b = row[j];
      if (a.pose < b.pose) {
        system.block(slot[next_slot]).noalias() -= a.Y * b.W->transpose();
      } else if (b.pose < a.pose) {
        system.block(slot[next_slot]).noalias() -= b.Y * a.W->transpose();
      } else {  // one camera observes the point twice
        const Matrix6d product = a.Y * b.W->transpose();
        system.diagonal(static_cast<size_t>(a.pose)) -= product + product.transpose();
      }
    }
  }
}

bool BundleAdjuster::Workspace::solve_step(double lambda) {
  const size_t points = V.size();
  start_reduced(lambda);
  size_t next_slot = 0;
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
      if (c < 0) continue;
      const Matrix6x3d Y = W[k] * V_inv[p];
      rhs.segment<6>(static_cast<Eigen::Index>(c) * 6).noalias() -= Y * b_p[p];
      row.push_back({c, &W[k], Y});
    }
    if (sparse) {
      add_sparse(next_slot);
    } else {
      subtract_point(row, S.data(), S.outerStride());
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
      if (c >= 0) r.noalias() -= W[k].transpose() * step_c.segment<6>(static_cast<Eigen::Index>(c) * 6);
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
  if (sparse) return system.solve(rhs, step_c);
  const Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>, Eigen::Lower> llt(S);
  if (llt.info() != Eigen::Success) return false;
  step_c = llt.solve(rhs);
  return true;
}

}  // namespace covis
