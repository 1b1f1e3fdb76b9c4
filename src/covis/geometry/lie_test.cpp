// SPDX-License-Identifier: Apache-2.0
// Sim(3), and the Jacobians of all three groups.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "covis/core/random.h"
#include "covis/geometry/sim3.h"

namespace covis {
namespace {

using Eigen::Vector3d;

double distance(const Sim3& a, const Sim3& b) {
  return (a.R() - b.R()).norm() + (a.t() - b.t()).norm() + std::abs(a.scale() - b.scale());
}

// Zero, tiny, random, near half a turn, rotation alone, scale alone.
std::vector<Vector7d> similarity_tangents() {
  Random random(5);
  std::vector<Vector7d> list{Vector7d::Zero(), Vector7d::Constant(1e-8)};
  for (int k = 0; k < 60; ++k) {
    Vector7d xi;
    for (int i = 0; i < 7; ++i) xi(i) = random.uniform(-1, 1);
    xi.segment<3>(3) *= (k % 5 == 0 ? std::numbers::pi - 1e-3 : random.uniform(0, 3)) / xi.segment<3>(3).norm();
    if (k % 7 == 0) xi(6) = 0;
    if (k % 11 == 0) xi.segment<3>(3).setZero();
    list.push_back(xi);
  }
  return list;
}

TEST(Sim3, GroupLaws) {
  const auto list = similarity_tangents();
  for (size_t i = 0; i < list.size(); ++i) {
    const Sim3 a = Sim3::exp(list[i]), b = Sim3::exp(list[(i + 7) % list.size()]),
               c = Sim3::exp(list[(i + 13) % list.size()]);
    EXPECT_LT(distance(a * a.inverse(), Sim3()), 1e-12);
    EXPECT_LT(distance((a * b) * c, a * (b * c)), 1e-11);
    EXPECT_LT((a.log() - list[i]).norm(), 1e-8) << list[i].transpose();
    EXPECT_LT(((a * b) * Vector3d(1, 2, 3) - a * (b * Vector3d(1, 2, 3))).norm(), 1e-11);
    const Vector7d small = 0.1 * list[(i + 3) % list.size()];
    EXPECT_LT(distance(a * Sim3::exp(small), Sim3::exp(a.adjoint() * small) * a), 1e-10);
    // One parameter subgroups.
    EXPECT_LT(distance(Sim3::exp(0.3 * list[i]) * Sim3::exp(0.2 * list[i]), Sim3::exp(0.5 * list[i])), 1e-12);
  }
}

TEST(Sim3, WithoutScaleItIsSe3) {
  for (const Vector7d& xi : similarity_tangents()) {
    Vector7d rigid = xi;
    rigid(6) = 0;
    const Sim3 s = Sim3::exp(rigid);
    const SE3 t = SE3::exp(rigid.head<6>());
    EXPECT_LT(distance(s, Sim3(t)), 1e-12);
    EXPECT_LT((Sim3::left_jacobian(rigid).topLeftCorner<6, 6>() - SE3::left_jacobian(rigid.head<6>())).norm(), 1e-12);
  }
}

TEST(Sim3, AsPoseSeesTheSamePixels) {
  const Sim3 s = Sim3::exp((Vector7d() << 0.1, -0.2, 0.3, 0.4, 0.5, -0.6, 0.7).finished());
  const Vector3d p(0.3, -0.4, 5);
  EXPECT_LT(((s * p).hnormalized() - (s.as_pose() * p).hnormalized()).norm(), 1e-12);
}

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

}  // namespace
}  // namespace covis
