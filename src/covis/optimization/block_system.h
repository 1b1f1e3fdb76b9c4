// SPDX-License-Identifier: Apache-2.0
// Symmetric positive definite systems made of N x N blocks, one row and column of blocks for each variable (a pose), of
// which few differ from zero. The pattern is fixed once; values are then written in place and solved again and again.
// Source: Davis, "Direct methods for sparse linear systems", 2006, chapters 4 and 7 (as in Eigen's SimplicialLDLT);
// ordering: Amestoy, Davis, Duff, "An approximate minimum degree ordering algorithm", SIAM J. Matrix Anal. 1996.
#pragma once

#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <algorithm>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace covis {

// Two variables that share a residual: (column, row) with row < column, so that sorting puts columns together.
using BlockPair = std::pair<int32_t, int32_t>;

inline BlockPair make_block_pair(int32_t a, int32_t b) { return {std::max(a, b), std::min(a, b)}; }

// An order of the variables that keeps the factor sparse: result[k] is the variable to become number k.
// The pairs may repeat and come in any order.
std::vector<int32_t> sparse_order(int32_t variables, std::span<const BlockPair> pairs);

template <int N>
class BlockSystem {
 public:
  using Block = Eigen::Matrix<double, N, N>;
  using BlockRef = Eigen::Map<Block, 0, Eigen::OuterStride<>>;

  // The pairs sorted and unique. Number the variables by sparse_order first: they are eliminated as they are numbered.
  void set_pattern(int32_t variables, std::span<const BlockPair> pairs) {
    first_.assign(static_cast<size_t>(variables) + 1, 0);
    rows_.clear();
    size_t next = 0;
    for (int32_t column = 0; column < variables; ++column) {
      for (; next < pairs.size() && pairs[next].first == column; ++next) rows_.push_back(pairs[next].second);
      rows_.push_back(column);
      first_[static_cast<size_t>(column) + 1] = static_cast<int32_t>(rows_.size());
    }
    matrix_.resize(variables * N, variables * N);
    matrix_.resizeNonZeros(static_cast<Eigen::Index>(rows_.size()) * N * N);
    int* row = matrix_.innerIndexPtr();
    int* start = matrix_.outerIndexPtr();
    for (int32_t column = 0; column < variables; ++column) {
      for (int q = 0; q < N; ++q) {
        *start++ = static_cast<int>(row - matrix_.innerIndexPtr());
        for (int32_t slot = first(column); slot < first(column + 1); ++slot) {
          for (int r = 0; r < N; ++r) *row++ = rows_[static_cast<size_t>(slot)] * N + r;
        }
      }
    }
    *start = static_cast<int>(row - matrix_.innerIndexPtr());
    solver_.analyzePattern(matrix_);
  }

  // Where the block of a pair of the pattern lies (a == b: the diagonal block).
  int32_t slot(BlockPair pair) const {
    const auto begin = rows_.begin() + first(pair.first), end = rows_.begin() + first(pair.first + 1);
    return static_cast<int32_t>(std::lower_bound(begin, end, pair.second) - rows_.begin());
  }

  // The block in row `row` and column `column` of a pair, by its slot and the pair's column.
  BlockRef block(int32_t slot, int32_t column) {
    const int32_t begin = first(column), blocks = first(column + 1) - begin;
    return BlockRef(matrix_.valuePtr() + N * (N * begin + (slot - begin)), Eigen::OuterStride<>(N * blocks));
  }
  // The whole block counts; only its upper triangle is read.
  BlockRef diagonal(int32_t variable) { return block(first(variable + 1) - 1, variable); }

  void set_zero() { std::fill_n(matrix_.valuePtr(), matrix_.nonZeros(), 0.0); }

  // False when the matrix is not positive definite.
  bool solve(const Eigen::VectorXd& rhs, Eigen::VectorXd& x) {
    solver_.factorize(matrix_);
    if (solver_.info() != Eigen::Success || !(solver_.vectorD().minCoeff() > 0)) return false;
    x = solver_.solve(rhs);
    return x.allFinite();
  }

 private:
  int32_t first(int32_t column) const { return first_[static_cast<size_t>(column)]; }

  std::vector<int32_t> first_;          // slots of column c: [first_[c], first_[c + 1]), the diagonal block last
  std::vector<int32_t> rows_;           // of each slot
  Eigen::SparseMatrix<double> matrix_;  // the upper triangle
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>, Eigen::Upper, Eigen::NaturalOrdering<int>> solver_;
};

}  // namespace covis
