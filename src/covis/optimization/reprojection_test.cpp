// SPDX-License-Identifier: Apache-2.0
#include "covis/optimization/reprojection.h"

#include <gtest/gtest.h>

#include "covis/optimization/test_problems.h"

namespace covis {
namespace {

TEST(Reprojection, JacobiansAgreeWithDifferences) {
  Random random(1);
  for (int trial = 0; trial < 100; ++trial) {
    const Eigen::Vector3d p(random.uniform(-2, 2), random.uniform(-2, 2), random.uniform(1, 8));
    for (const Disparity& disparity : {Disparity{}, Disparity{20, 1}}) {
      const Eigen::Matrix3d J_pi = projection_jacobian(p, kCamera, disparity);
      const Matrix3x6d J = pose_jacobian(J_pi, p);
      constexpr double kStep = 1e-6;
      for (int k = 0; k < 6; ++k) {
        Vector6d xi = Vector6d::Zero();
        xi(k) = kStep;
        const Eigen::Vector3d difference = (reprojection_residual(SE3::exp(-xi) * p, kCamera, 300, 200, disparity) -
                                            reprojection_residual(SE3::exp(xi) * p, kCamera, 300, 200, disparity)) /
                                           (2 * kStep);
        EXPECT_LT((difference - J.col(k)).norm(), 1e-5 * (1 + J.col(k).norm()));
      }
    }
  }
}

}  // namespace
}  // namespace covis
