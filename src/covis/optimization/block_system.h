// SPDX-License-Identifier: Apache-2.0
// Symmetric positive definite systems made of N x N blocks, one row and column of blocks for each variable (a pose), of
// which few differ from zero. The pattern is fixed once; values are then written in place and solved again and again,
// without allocations. A Cholesky factorisation by whole blocks, several times faster than one by single numbers.
// Source: Davis, "Direct methods for sparse linear systems", 2006, sections 4.1 (elimination tree), 4.7 (up-looking
// Cholesky); order: Amestoy, Davis, Duff, "An approximate minimum degree ordering algorithm", SIAM J. Matrix Anal.
// 1996.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "covis/core/aligned.h"

namespace covis {

// Two variables that share a residual: (column, row) with row < column, so that sorting puts columns together.
using BlockPair = std::pair<int32_t, int32_t>;

constexpr BlockPair make_block_pair(int32_t a, int32_t b) { return a > b ? BlockPair{a, b} : BlockPair{b, a}; }

// Sorts pairs and drops repetitions.
void make_unique(std::vector<BlockPair>& pairs);

// An order of the variables that keeps the factor sparse: result[k] is the variable to become number k.
std::vector<int32_t> sparse_order(int32_t variables, std::span<const BlockPair> pairs);

// The places of the blocks of a matrix and of its factor.
struct BlockPattern {
  std::vector<uint32_t> first;  // the matrix' blocks of column c above the diagonal: [first[c], first[c + 1])
  std::vector<int32_t> row;     // row of each of them, increasing in a column

  std::vector<uint32_t> factor_first;   // the factor's blocks of column c below the diagonal: [.[c], .[c + 1])
  std::vector<int32_t> factor_row;      // row of each of them, increasing in a column
  std::vector<uint32_t> pattern_first;  // the columns in which row r of the factor has blocks left of the diagonal,
  std::vector<int32_t> pattern;         // increasing: pattern[pattern_first[r]] to pattern[pattern_first[r + 1]]

  // The pattern of sorted unique pairs.
  BlockPattern() = default;
  BlockPattern(int32_t variables, std::span<const BlockPair> pairs);
  uint32_t slot(BlockPair pair) const;
};

template <int N>
class BlockSystem {
 public:
  using Block = Eigen::Matrix<double, N, N>;

  // The pairs sorted and unique. Number the variables by sparse_order first: they are eliminated as they are numbered.
  void set_pattern(int32_t variables, std::span<const BlockPair> pairs);

  // The block in row `row` and column `column` of a pair of the pattern is block(slot(pair)).
  uint32_t slot(BlockPair pair) const { return pattern_.slot(pair); }
  Block& block(uint32_t slot) { return blocks_[slot]; }
  Block& diagonal(size_t variable) { return diagonal_[variable]; }  // its lower triangle is read
  void set_zero();

  // Solves matrix * x = rhs; false when the matrix is not positive definite. The matrix stays as it is.
  bool solve(const Eigen::VectorXd& rhs, Eigen::VectorXd& x);

 private:
  bool factorize();

  BlockPattern pattern_;
  AlignedVector<Block> blocks_, diagonal_;
  AlignedVector<Block> factor_;   // L below the diagonal, by columns
  AlignedVector<Block> inverse_;  // inverses of the factor's diagonal blocks
  AlignedVector<Block> work_;     // one row of the factor, transposed
  std::vector<uint32_t> filled_;  // up to where each column of the factor is known
};

extern template class BlockSystem<6>;
extern template class BlockSystem<7>;

}  // namespace covis
