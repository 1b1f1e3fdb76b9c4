// SPDX-License-Identifier: Apache-2.0
#include "covis/geometry/measurement.h"

#include <gtest/gtest.h>

namespace covis {
namespace {

TEST(Measurement, TheVirtualBaselineOfADepthSensorCancelsOut) {
  Pinhole camera{500, 500, 320, 240, 0};
  camera.depth_noise = DepthNoise::kinect();
  const Eigen::Vector3d p_c(0.3, -0.2, 2.0);
  double first = 0;
  for (const double baseline : {0.08, 0.01, 0.5, 4.0}) {
    camera.bf = 500 * baseline;
    const Disparity disparity = disparity_of_depth(camera, 2.01f, 0.25f);
    const Chi2 chi2(reprojection_residual(p_c, camera, 395.5f, 190, disparity), 0.25, disparity);
    if (first == 0) first = chi2.disparity;
    EXPECT_GT(chi2.disparity, 0.1);
    EXPECT_NEAR(chi2.disparity, first, 1e-3 * first);
    EXPECT_NEAR(chi2.pixel, 0.0625, 1e-6);
  }
}

TEST(Measurement, FartherDepthWeighsLess) {
  Pinhole camera{500, 500, 320, 240, 40};
  camera.depth_noise = {0, 0.01};
  const auto sigma_of_depth = [&](float depth) {
    return std::sqrt(1 / static_cast<double>(disparity_of_depth(camera, depth, 1e6f).inv_sigma2)) * depth * depth /
           camera.bf;
  };
  EXPECT_NEAR(sigma_of_depth(1), kAlikeErrors * 0.01, 1e-5);
  EXPECT_NEAR(sigma_of_depth(3), kAlikeErrors * 0.09, 1e-4);
  EXPECT_FALSE(disparity_of_depth(camera, 0, 1).measured());
  EXPECT_FALSE(disparity_of_depth(camera, -1, 1).measured());
}

TEST(Measurement, TheThirdRowIsTheRightColumnForStereoOnly) {
  Pinhole camera{500, 500, 320, 240, 40};
  const Eigen::Vector3d p_c(0, 0, 2);  // disparity 20
  const Disparity disparity{21, 1};
  EXPECT_NEAR(reprojection_residual(p_c, camera, 324, 240, disparity).z(), 3, 1e-9);
  camera.depth_noise = DepthNoise::kinect();
  EXPECT_NEAR(reprojection_residual(p_c, camera, 324, 240, disparity).z(), 1, 1e-9);
  EXPECT_EQ(reprojection_residual(p_c, camera, 324, 240, {}).z(), 0);
}

TEST(Measurement, AWrongDepthAloneRulesOutAStereoMatchOnly) {
  Pinhole camera{500, 500, 320, 240, 40};
  const Disparity disparity{20, 1};
  const Chi2 wrong({1, 1, 9}, 1, disparity);
  EXPECT_FALSE(within_bound(wrong, camera, disparity));
  camera.depth_noise = DepthNoise::kinect();
  EXPECT_TRUE(within_bound(wrong, camera, disparity));
  EXPECT_FALSE(within_bound(Chi2({2, 2, 9}, 1, disparity), camera, disparity));
}

}  // namespace
}  // namespace covis
