// SPDX-License-Identifier: Apache-2.0
#include "covis/optimization/block_system.h"

#include <Eigen/Cholesky>
#include <Eigen/OrderingMethods>
#include <Eigen/SparseCore>
#include <algorithm>

namespace covis {

void make_unique(std::vector<BlockPair>& pairs) {
  std::sort(pairs.begin(), pairs.end());
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
}

std::vector<int32_t> sparse_order(int32_t variables, std::span<const BlockPair> pairs) {
  std::vector<Eigen::Triplet<double>> entries;
  entries.reserve(pairs.size() + static_cast<size_t>(variables));
  for (const auto& [column, row] : pairs) entries.emplace_back(row, column, 1);
  for (int32_t k = 0; k < variables; ++k) entries.emplace_back(k, k, 1);
  Eigen::SparseMatrix<double> matrix(variables, variables);
  matrix.setFromTriplets(entries.begin(), entries.end());
  Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, int> order;
  Eigen::AMDOrdering<int>()(matrix, order);
  return {order.indices().data(), order.indices().data() + order.indices().size()};
}

BlockPattern::BlockPattern(int32_t variables, std::span<const BlockPair> pairs) {
  const auto n = static_cast<size_t>(variables);
  first.assign(n + 1, 0);
  row.reserve(pairs.size());
  for (const auto& [c, r] : pairs) {
    ++first[static_cast<size_t>(c) + 1];
    row.push_back(r);
  }
  for (size_t c = 0; c < n; ++c) first[c + 1] += first[c];

  // Row k of the factor has blocks in the columns on the paths from the matrix' blocks up the elimination tree.
  std::vector<int32_t> parent(n, -1), mark(n, -1);
  factor_first.assign(n + 1, 0);
  pattern_first.assign(1, 0);
  for (int32_t k = 0; k < variables; ++k) {
    mark[static_cast<size_t>(k)] = k;
    for (uint32_t b = first[static_cast<size_t>(k)]; b < first[static_cast<size_t>(k) + 1]; ++b) {
      for (auto i = static_cast<size_t>(row[b]); mark[i] != k; i = static_cast<size_t>(parent[i])) {
        if (parent[i] < 0) parent[i] = k;
        mark[i] = k;
        ++factor_first[i + 1];
        pattern.push_back(static_cast<int32_t>(i));
      }
    }
    std::sort(pattern.begin() + pattern_first.back(), pattern.end());
    pattern_first.push_back(static_cast<uint32_t>(pattern.size()));
  }
  for (size_t c = 0; c < n; ++c) factor_first[c + 1] += factor_first[c];
  factor_row.resize(pattern.size());
  std::vector<uint32_t> next(factor_first.begin(), factor_first.end() - 1);
  for (int32_t k = 0; k < variables; ++k) {
    for (uint32_t e = pattern_first[static_cast<size_t>(k)]; e < pattern_first[static_cast<size_t>(k) + 1]; ++e) {
      factor_row[next[static_cast<size_t>(pattern[e])]++] = k;
    }
  }
}

uint32_t BlockPattern::slot(BlockPair pair) const {
  const auto column = static_cast<size_t>(pair.first);
  const auto begin = row.begin() + first[column], end = row.begin() + first[column + 1];
  return static_cast<uint32_t>(std::lower_bound(begin, end, pair.second) - row.begin());
}

template <int N>
void BlockSystem<N>::set_pattern(int32_t variables, std::span<const BlockPair> pairs) {
  pattern_ = BlockPattern(variables, pairs);
  const auto n = static_cast<size_t>(variables);
  blocks_.resize(pairs.size());
  factor_.resize(pattern_.factor_row.size());
  for (auto* array : {&diagonal_, &inverse_, &work_}) array->resize(n);
  filled_.resize(n);
}

template <int N>
void BlockSystem<N>::set_zero() {
  std::fill(blocks_.begin(), blocks_.end(), Block::Zero());
  std::fill(diagonal_.begin(), diagonal_.end(), Block::Zero());
}

// Row k of L from the rows above: with Y = (row k of L)' a block column, for i increasing  Y_i = L_ii^-1 Y_i,
// Y_p -= L_pi Y_i for i < p < k,  and at the end  L_kk L_kk' = A_kk - sum Y_i' Y_i.
template <int N>
bool BlockSystem<N>::factorize() {
  const size_t n = diagonal_.size();
  std::copy_n(pattern_.factor_first.begin(), n, filled_.begin());
  for (size_t k = 0; k < n; ++k) {
    const std::span<const int32_t> columns(pattern_.pattern.data() + pattern_.pattern_first[k],
                                           pattern_.pattern.data() + pattern_.pattern_first[k + 1]);
    for (const int32_t i : columns) work_[static_cast<size_t>(i)].setZero();
    for (uint32_t b = pattern_.first[k]; b < pattern_.first[k + 1]; ++b) {
      work_[static_cast<size_t>(pattern_.row[b])] = blocks_[b];
    }
    Block rest = diagonal_[k];
    for (const int32_t column : columns) {
      const auto i = static_cast<size_t>(column);
      const Block y = inverse_[i] * work_[i];
      for (uint32_t e = pattern_.factor_first[i]; e < filled_[i]; ++e) {
        work_[static_cast<size_t>(pattern_.factor_row[e])].noalias() -= factor_[e] * y;
      }
      factor_[filled_[i]++] = y.transpose();
      rest.noalias() -= y.transpose() * y;
    }
    const Eigen::LLT<Block> llt(rest);
    if (llt.info() != Eigen::Success) return false;
    inverse_[k] = llt.matrixL().solve(Block::Identity());
  }
  return true;
}

template <int N>
bool BlockSystem<N>::solve(const Eigen::VectorXd& rhs, Eigen::VectorXd& x) {
  if (!factorize()) return false;
  const size_t n = diagonal_.size();
  x = rhs;
  const auto part = [&x](auto k) { return x.segment<N>(static_cast<Eigen::Index>(k) * N); };
  for (size_t k = 0; k < n; ++k) {
    part(k) = (inverse_[k] * part(k)).eval();
    for (uint32_t e = pattern_.factor_first[k]; e < pattern_.factor_first[k + 1]; ++e) {
      part(pattern_.factor_row[e]).noalias() -= factor_[e] * part(k);
    }
  }
  for (size_t k = n; k-- > 0;) {
    for (uint32_t e = pattern_.factor_first[k]; e < pattern_.factor_first[k + 1]; ++e) {
      part(k).noalias() -= factor_[e].transpose() * part(pattern_.factor_row[e]);
    }
    part(k) = (inverse_[k].transpose() * part(k)).eval();
  }
  return x.allFinite();
}

template class BlockSystem<6>;
template class BlockSystem<7>;

}  // namespace covis
