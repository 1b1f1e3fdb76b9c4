// SPDX-License-Identifier: Apache-2.0
#include "covis/geometry/alignment.h"

#include <gtest/gtest.h>

#include <vector>

#include "covis/geometry/test_geometry.h"

namespace covis {
namespace {

using Eigen::Vector3d;

TEST(Alignment, FindsMotionAndScale) {
  Random random(4);
  for (const bool scaled : {false, true}) {
    std::vector<Vector3d> a, b;
    const SE3 T(so3_exp(random_vector(random, 2)), random_vector(random, 5));
    const double scale = scaled ? 2.5 : 1;
    for (int i = 0; i < 20; ++i) {
      a.push_back(random_vector(random, 3));
      b.push_back(scale * (T.R() * a.back()) + T.t());
    }
    const auto found = align(a, b, scaled ? Scale::free : Scale::fixed);
    ASSERT_TRUE(found);
    EXPECT_LT(distance(found->T_ba, T), 1e-9);
    EXPECT_NEAR(found->scale, scale, 1e-9);
    EXPECT_LT(found->rmse, 1e-9);
    EXPECT_TRUE(found->unique);
  }
  // A mirror image is no rotation: it must not be called one.
  std::vector<Vector3d> a, b;
  for (int i = 0; i < 20; ++i) {
    a.push_back(random_vector(random, 3));
    b.emplace_back(-a.back().x(), a.back().y(), a.back().z());
  }
  EXPECT_NEAR(align(a, b, Scale::fixed)->T_ba.R().determinant(), 1, 1e-9);
  // A straight line can be aligned, not uniquely.
  for (int i = 0; i < 20; ++i)
    b[static_cast<size_t>(i)] = Vector3d(i, 0, 0), a[static_cast<size_t>(i)] = Vector3d(0, i, 0);
  const auto line = align(a, b, Scale::fixed);
  ASSERT_TRUE(line);
  EXPECT_LT(line->rmse, 1e-9);
  EXPECT_FALSE(line->unique);
  EXPECT_FALSE(align(std::vector<Vector3d>(2), std::vector<Vector3d>(2), Scale::fixed));
  EXPECT_FALSE(align(std::vector<Vector3d>(5, Vector3d(1, 1, 1)), b, Scale::fixed));
}

}  // namespace
}  // namespace covis
