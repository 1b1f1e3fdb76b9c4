// SPDX-License-Identifier: Apache-2.0
// The Jacobians of all three groups.
#include "covis/geometry/lie.h"

#include <gtest/gtest.h>

#include <limits>

#include "covis/geometry/sim3.h"
#include "covis/geometry/test_geometry.h"

namespace covis {
namespace {

using Eigen::Vector3d;

template <class Group, class Tangent>
void expect_left_jacobian(const Tangent& xi) {
  constexpr double kStep = 1e-6;
  const auto J = Group::left_jacobian(xi);
  const Group inverse = Group::exp(xi).inverse();
  for (int k = 0; k < xi.size(); ++k) {
    Tangent d = Tangent::Zero();
    d(k) = kStep;
    const Tangent difference =
        ((Group::exp(xi + d) * inverse).log() - (Group::exp(xi - d) * inverse).log()) / (2 * kStep);
    EXPECT_LT((difference - J.col(k)).norm(), 1e-7 * (1 + J.col(k).norm())) << xi.transpose() << ", column " << k;
  }
}

TEST(Lie, LeftJacobiansAgreeWithDifferences) {
  for (const Vector7d& xi : similarity_tangents()) {
    expect_left_jacobian<Sim3>(xi);
    expect_left_jacobian<SE3, Vector6d>(xi.head<6>());
    const Vector3d phi = xi.segment<3>(3);
    const Eigen::Matrix3d J = so3_left_jacobian(phi);
    for (int k = 0; k < 3; ++k) {
      const Vector3d d = 1e-6 * Vector3d::Unit(k);
      const Vector3d difference = (so3_log(so3_exp(phi + d) * so3_exp(phi).transpose()) -
                                   so3_log(so3_exp(phi - d) * so3_exp(phi).transpose())) /
                                  2e-6;
      EXPECT_LT((difference - J.col(k)).norm(), 1e-7);
    }
  }
}

// A step that is not finite is to be refused, not to be waited for.
TEST(PhiFunction, EndsForWhatIsNotFinite) {
  for (const double value : {std::numeric_limits<double>::infinity(), std::numeric_limits<double>::quiet_NaN()})
    EXPECT_FALSE(phi_function<3>(Eigen::Matrix3d::Constant(value)).allFinite());
  EXPECT_FALSE(phi_function<3>(Eigen::Matrix3d::Constant(1e300)).allFinite());
}

}  // namespace
}  // namespace covis
