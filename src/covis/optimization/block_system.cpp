// SPDX-License-Identifier: Apache-2.0
#include "covis/optimization/block_system.h"

#include <Eigen/OrderingMethods>

namespace covis {

std::vector<int32_t> sparse_order(int32_t variables, std::span<const BlockPair> pairs) {
  std::vector<Eigen::Triplet<double>> entries;
  entries.reserve(pairs.size() + static_cast<size_t>(variables));
  for (const auto& [column, row] : pairs) entries.emplace_back(row, column, 1);
  for (int32_t k = 0; k < variables; ++k) entries.emplace_back(k, k, 1);
  Eigen::SparseMatrix<double> pattern(variables, variables);
  pattern.setFromTriplets(entries.begin(), entries.end());
  Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, int> order;
  Eigen::AMDOrdering<int>()(pattern, order);
  return {order.indices().data(), order.indices().data() + order.indices().size()};
}

}  // namespace covis
