// SPDX-License-Identifier: Apache-2.0
#include "covis/geometry/depth_registration.h"

#include <gtest/gtest.h>

#include <limits>

namespace covis {
namespace {

TEST(DepthRegistration, IsThatOfTwoCameras) {
  // A depth camera of 580 pixels, its middle at (330, 236), 4 cm right of and 1 cm above one of 520 pixels.
  const Eigen::Vector2d centre(322, 238);
  const DepthRegistration registration{580.0 / 520, 8, -2, -580 * 0.04, 580 * 0.01};
  for (const Eigen::Vector3d& p : {Eigen::Vector3d(0.3, -0.2, 1.5), Eigen::Vector3d(-1, 0.4, 4)}) {
    const Eigen::Vector2d image = centre + 520 * p.hnormalized();
    const Eigen::Vector2d depth =
        Eigen::Vector2d(330, 236) + 580 * Eigen::Vector3d(p - Eigen::Vector3d(0.04, -0.01, 0)).hnormalized();
    EXPECT_LT((registration.pixel(image, centre, 1 / p.z()) - depth).norm(), 1e-9);
  }
}

TEST(DepthRegistration, NoneIsInTheSamePlace) {
  const DepthRegistration none;
  EXPECT_FALSE(none.any());
  EXPECT_EQ(none.pixel({12.5, 400}, {320, 240}, 0.7), Eigen::Vector2d(12.5, 400));
  EXPECT_TRUE((DepthRegistration{.parallax_y = 1}).any());
}

TEST(DepthRegistration, AbsurdOnesAreNotValid) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(DepthRegistration{}.valid());
  for (const DepthRegistration& wrong :
       {DepthRegistration{.scale = 0}, DepthRegistration{.scale = kNan}, DepthRegistration{.scale = 11},
        DepthRegistration{.shift_x = 1e9}, DepthRegistration{.shift_y = kNan},
        DepthRegistration{.parallax_x = -std::numeric_limits<double>::infinity()}})
    EXPECT_FALSE(wrong.valid());
}

TEST(DepthRegistration, SaysWhatItIs) {
  EXPECT_EQ(description({1.107, 5.5, 3, 14, 0}),
            "1.1070 times as large, moved by 5.5 and 3.0 pixels, and by 14.0 and 0.0 at a metre");
}

}  // namespace
}  // namespace covis
