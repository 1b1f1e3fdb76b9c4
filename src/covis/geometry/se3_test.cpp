// SPDX-License-Identifier: Apache-2.0
#include "covis/geometry/se3.h"

#include <gtest/gtest.h>

#include <numbers>
#include <vector>

#include "covis/geometry/test_geometry.h"

namespace covis {
namespace {

using Eigen::Vector3d;

std::vector<Vector6d> tangents() {
  Random random(1);
  std::vector<Vector6d> list{Vector6d::Zero(), Vector6d::Constant(1e-8)};
  for (int k = 0; k < 50; ++k) {
    Vector6d xi;
    const Vector3d axis = random_vector(random, 1).normalized();
    const double angle = k % 5 == 0 ? std::numbers::pi - 1e-7 * k : random.uniform(0, 3.1);
    xi << random_vector(random, 3), angle * axis;
    list.push_back(xi);
  }
  return list;
}

TEST(Se3, GroupLaws) {
  const auto list = tangents();
  for (size_t i = 0; i < list.size(); ++i) {
    const SE3 a = SE3::exp(list[i]), b = SE3::exp(list[(i + 7) % list.size()]),
              c = SE3::exp(list[(i + 13) % list.size()]);
    EXPECT_LT(distance(a * a.inverse(), SE3()), 1e-12);
    EXPECT_LT(distance((a * b) * c, a * (b * c)), 1e-12);
    EXPECT_LT(distance(SE3::exp(a.log()), a), 1e-9);
    EXPECT_LT((SE3::exp(list[i]).log() - list[i]).norm(), 1e-6) << list[i].transpose();
    EXPECT_LT((a.R() * a.R().transpose() - Eigen::Matrix3d::Identity()).norm(), 1e-12);
    EXPECT_LT(((a * b) * Vector3d(1, 2, 3) - a * (b * Vector3d(1, 2, 3))).norm(), 1e-11);
    const Vector6d small = 0.1 * list[(i + 3) % list.size()];
    EXPECT_LT(distance(a * SE3::exp(small), SE3::exp(a.adjoint() * small) * a), 1e-10);
    EXPECT_LT((a * a.centre()).norm(), 1e-12);
  }
}

}  // namespace
}  // namespace covis
