// SPDX-License-Identifier: Apache-2.0
#include "covis/matching/epipolar_match.h"

#include <gtest/gtest.h>

#include "covis/matching/test_matching.h"

namespace covis {
namespace {

const Pinhole kCamera{500, 500, 320, 240, 40};

TEST(EpipolarMatch, TakesTheOneNearTheLine) {
  Random random(7);
  const SE3 T_ba(so3_exp({0.02, -0.05, 0.01}), Eigen::Vector3d(-0.4, 0.05, 0.02));
  Features a = no_features(), b = no_features();
  int expected = 0;
  for (int i = 0; i < 300; ++i) {
    const Eigen::Vector3d p_a(random.uniform(-2, 2), random.uniform(-1.5, 1.5), random.uniform(3, 8));
    const Eigen::Vector2d at_a = kCamera.project(p_a), at_b = kCamera.project(T_ba * p_a);
    const Descriptor d = random_descriptor(random);
    const bool off = i % 3 == 0;  // moved away from its line
    add(a, static_cast<float>(at_a.x()), static_cast<float>(at_a.y()), 0, d);
    add(b, static_cast<float>(at_b.x()), static_cast<float>(at_b.y()) + (off ? 8.0f : 0.0f), 0, turned(d, 20, random));
    if (!off) ++expected;
  }
  const auto matches = match_epipolar(kCamera, a, {}, b, {}, T_ba, {});
  EXPECT_EQ(static_cast<int>(matches.size()), expected);
  for (const FeatureMatch& m : matches) {
    EXPECT_EQ(m.a, m.b);
    EXPECT_NE(m.a % 3, 0);
  }
}

TEST(EpipolarMatch, TakesNoneOfSeveralThatLookAlikeAlongTheLine) {
  Random random(9);
  const SE3 T_ba(Eigen::Matrix3d::Identity(), Eigen::Vector3d(-0.4, 0, 0));  // lines are rows
  const Descriptor tile = random_descriptor(random), once = random_descriptor(random);
  Features a = no_features(), b = no_features();
  add(a, 300, 200, 0, tile);
  add(a, 300, 260, 0, once);
  add(b, 260, 200, 0, turned(tile, 20, random));
  add(b, 220, 200, 0, turned(tile, 22, random));  // the next joint
  add(b, 260, 260, 0, turned(once, 20, random));
  add(b, 262, 260, 0, turned(once, 22, random));  // the same corner found twice
  const auto unique = match_epipolar(kCamera, a, {}, b, {}, T_ba, {.max_ratio = 0.7});
  ASSERT_EQ(unique.size(), 1u);
  EXPECT_EQ(unique[0].a, 1);
  EXPECT_EQ(unique[0].b, 2);
  EXPECT_EQ(match_epipolar(kCamera, a, {}, b, {}, T_ba, {}).size(), 2u) << "without a ratio";
}

TEST(EpipolarMatch, StaysAwayFromTheEpipole) {
  Random random(8);
  const SE3 T_ba(Eigen::Matrix3d::Identity(), Eigen::Vector3d(0, 0, 1));  // straight ahead: the epipole is the centre
  Features a = no_features(), b = no_features();
  const Descriptor d = random_descriptor(random);
  add(a, 321, 240, 0, d);
  add(b, 322, 240, 0, d);
  EXPECT_TRUE(match_epipolar(kCamera, a, {}, b, {}, T_ba, {}).empty());
  EXPECT_EQ(match_epipolar(kCamera, a, {}, b, {}, T_ba, {.epipole_margin = 1}).size(), 1u);
  EXPECT_TRUE(match_epipolar(kCamera, a, {}, b, {}, T_ba.inverse(), {}).empty()) << "straight back";
}

}  // namespace
}  // namespace covis
