// SPDX-License-Identifier: Apache-2.0
#include "covis/geometry/triangulation.h"

#include <gtest/gtest.h>

#include "covis/geometry/test_geometry.h"

namespace covis {
namespace {

using Eigen::Vector3d;

TEST(Triangulation, FindsThePoint) {
  Random random(3);
  for (int trial = 0; trial < 200; ++trial) {
    const Vector3d p(random.uniform(-2, 2), random.uniform(-2, 2), random.uniform(3, 10));
    const SE3 T_1w(so3_exp(random_vector(random, 0.1)), random_vector(random, 0.3));
    const SE3 T_2w(so3_exp(random_vector(random, 0.1)), random_vector(random, 0.3) + Vector3d(1, 0, 0));
    const Vector3d a = T_1w * p, b = T_2w * p;
    const auto found = triangulate(T_1w, a / a.z(), T_2w, b / b.z());
    ASSERT_TRUE(found);
    EXPECT_LT((*found - p).norm(), 1e-8);
  }
}

}  // namespace
}  // namespace covis
