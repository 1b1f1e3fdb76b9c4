// SPDX-License-Identifier: Apache-2.0
#include "covis/geometry/sim3.h"

#include <gtest/gtest.h>

#include "covis/geometry/test_geometry.h"

namespace covis {
namespace {

using Eigen::Vector3d;

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

}  // namespace
}  // namespace covis
