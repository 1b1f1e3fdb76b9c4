// SPDX-License-Identifier: Apache-2.0
#include "covis/optimization/observation_blocks.h"

#include <gtest/gtest.h>

#include <tuple>

#include "covis/core/random.h"
#include "covis/core/test_targets.h"

namespace covis {
namespace {

// The scalar twin and every instruction set give the products as they are written.
TEST(ObservationBlocks, AreTheProductsOfTheJacobians) {
  Random random(5);
  const auto any = [&] { return random.uniform(-1, 1); };
  for (int k = 0; k < 20; ++k) {
    const Eigen::Vector3d weight = Eigen::Vector3d::NullaryExpr(any), e = Eigen::Vector3d::NullaryExpr(any);
    WeightedJacobians jacobians;
    jacobians.J_c = Matrix6x3d::NullaryExpr(any);
    jacobians.wJ_c = jacobians.J_c * weight.asDiagonal();
    jacobians.J_p = Eigen::Matrix3d::NullaryExpr(any);
    const Matrix6d U_start = Matrix6d::NullaryExpr(any);
    const Vector6d b_start = Vector6d::NullaryExpr(any);
    expect_scalar_twin([&] {
      Matrix6d U = U_start;
      Vector6d b = b_start;
      Matrix6x3d W;
      add_observation(jacobians, e, U, b, W);
      const Matrix6x3d weighted = jacobians.J_c * weight.asDiagonal();
      EXPECT_LT((U - U_start - weighted * jacobians.J_c.transpose()).cwiseAbs().maxCoeff(), 1e-14);
      EXPECT_LT((b - b_start - weighted * e).cwiseAbs().maxCoeff(), 1e-14);
      EXPECT_LT((W - weighted * jacobians.J_p).cwiseAbs().maxCoeff(), 1e-14);
      return std::tuple(U, b, W);
    });
  }
}

}  // namespace
}  // namespace covis
