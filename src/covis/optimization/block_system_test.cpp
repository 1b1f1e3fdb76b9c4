// SPDX-License-Identifier: Apache-2.0
#include "covis/optimization/block_system.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>

#include "covis/core/random.h"

namespace covis {
namespace {

template <int N>
void solves_like_a_dense_solver(uint64_t seed) {
  Random random(seed);
  const auto n = static_cast<int32_t>(1 + random.below(30));
  std::vector<BlockPair> pairs;
  for (uint32_t k = random.below(60); n > 1 && k > 0; --k) {
    const auto a = static_cast<int32_t>(random.below(static_cast<uint32_t>(n)));
    const auto b = static_cast<int32_t>(random.below(static_cast<uint32_t>(n)));
    if (a != b) pairs.push_back(make_block_pair(a, b));
  }
  make_unique(pairs);
  const auto size = static_cast<Eigen::Index>(n) * N;
  BlockSystem<N> system;
  system.set_pattern(n, pairs);
  Eigen::VectorXd rhs(size), x;
  for (double& value : rhs) value = random.normal();
  for (int round = 0; round < 2; ++round) {  // the second with other values in the same pattern
    system.set_zero();
    Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(size, size);
    for (const auto& [column, row] : pairs) {
      auto& block = system.block(system.slot({column, row}));
      for (double& value : block.reshaped()) value = random.normal();
      dense.block<N, N>(row * N, column * N) = block;
      dense.block<N, N>(column * N, row * N) = block.transpose();
    }
    for (int32_t c = 0; c < n; ++c) dense.diagonal().segment<N>(c * N).setConstant(4.0 * N * n);
    for (int32_t c = 0; c < n; ++c) system.diagonal(static_cast<size_t>(c)) = dense.block<N, N>(c * N, c * N);
    ASSERT_TRUE(system.solve(rhs, x));
    EXPECT_LT((x - dense.partialPivLu().solve(rhs)).norm(), 1e-12);
    system.diagonal(static_cast<size_t>(n) / 2)(0, 0) = -1;
    EXPECT_FALSE(system.solve(rhs, x));
  }
}

TEST(BlockSystem, SolvesLikeADenseSolver) {
  for (uint64_t seed = 1; seed <= 50; ++seed) {
    solves_like_a_dense_solver<6>(seed);
    solves_like_a_dense_solver<7>(seed);
  }
}

TEST(BlockSystem, OrderIsAPermutationThatAvoidsFill) {
  // A star: eliminated from its middle everything fills, middle last nothing does.
  std::vector<BlockPair> pairs;
  for (int32_t c = 1; c < 40; ++c) pairs.push_back(make_block_pair(0, c));
  make_unique(pairs);
  std::vector<int32_t> order = sparse_order(40, pairs);
  const auto middle = std::find(order.begin(), order.end(), 0) - order.begin();
  EXPECT_GE(middle, 38);
  std::sort(order.begin(), order.end());
  for (int32_t c = 0; c < 40; ++c) EXPECT_EQ(order[static_cast<size_t>(c)], c);
  EXPECT_EQ(BlockPattern(40, pairs).factor_row.size(), 39u * 40 / 2);  // numbered as given, the middle first
  std::vector<BlockPair> renumbered;
  for (int32_t c = 0; c < 39; ++c) renumbered.push_back(make_block_pair(39, c));
  EXPECT_EQ(BlockPattern(40, renumbered).factor_row.size(), 39u);
}

}  // namespace
}  // namespace covis
