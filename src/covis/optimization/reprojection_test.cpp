// SPDX-License-Identifier: Apache-2.0
#include "covis/optimization/reprojection.h"

#include <gtest/gtest.h>

#include "covis/optimization/test_problems.h"

namespace covis {
namespace {

void expect_right(const Eigen::Vector3d& p, const Pinhole& camera, const Disparity& disparity) {
  constexpr double kStep = 1e-6;
  const Matrix3x6d J = pose_jacobian(projection_jacobian(p, camera, disparity), p);
  for (int k = 0; k < 6; ++k) {
    Vector6d xi = Vector6d::Zero();
    xi(k) = kStep;
    const Eigen::Vector3d difference = (reprojection_residual(SE3::exp(-xi) * p, camera, 300, 200, disparity) -
                                        reprojection_residual(SE3::exp(xi) * p, camera, 300, 200, disparity)) /
                                       (2 * kStep);
    EXPECT_LT((difference - J.col(k)).norm(), 1e-5 * (1 + J.col(k).norm()));
  }
}

TEST(Reprojection, JacobiansAgreeWithDifferences) {
  Random random(1);
  Pinhole depth_camera = kCamera;
  depth_camera.depth_noise = DepthNoise::kinect();
  for (int trial = 0; trial < 100; ++trial) {
    const Eigen::Vector3d p(random.uniform(-2, 2), random.uniform(-2, 2), random.uniform(1, 8));
    for (const Pinhole& camera : {kCamera, depth_camera}) {
      for (const Disparity& disparity : {Disparity{}, Disparity{20, 1}}) expect_right(p, camera, disparity);
    }
  }
}

}  // namespace
}  // namespace covis
