// SPDX-License-Identifier: Apache-2.0
#include "covis/optimization/reduced_blocks.h"

#include <gtest/gtest.h>

#include <vector>

#include "covis/core/random.h"
#include "covis/core/test_targets.h"

namespace covis {
namespace {

// The scalar twin and every instruction set give the product as it is written, also where one pose observes the point
// twice.
TEST(ReducedBlocks, SubtractAPointFromTheLowerTriangle) {
  Random random(5);
  const auto any = [&] { return random.uniform(-1, 1); };
  for (const std::vector<int32_t>& seen_by : {std::vector<int32_t>{}, {3}, {0, 2, 5}, {4, 1, 1, 0, 5}}) {
    std::vector<Matrix6x3d> W(seen_by.size());
    std::vector<PoseOfPoint> poses;
    for (size_t k = 0; k < seen_by.size(); ++k) {
      W[k] = Matrix6x3d::NullaryExpr(any);
      poses.push_back({seen_by[k], &W[k], Matrix6x3d::NullaryExpr(any)});
    }
    const Eigen::MatrixXd start = Eigen::MatrixXd::NullaryExpr(36, 36, any);
    Eigen::MatrixXd expected = start;
    for (const PoseOfPoint& i : poses) {
      for (const PoseOfPoint& j : poses) {
        if (j.pose <= i.pose) expected.block<6, 6>(6 * i.pose, 6 * j.pose) -= i.Y * j.W->transpose();
      }
    }
    expect_scalar_twin([&] {
      Eigen::MatrixXd S = start;
      subtract_point(poses, S.data(), S.outerStride());
      EXPECT_LT((S - expected).cwiseAbs().maxCoeff(), 1e-15);
      return S;
    });
  }
}

}  // namespace
}  // namespace covis
