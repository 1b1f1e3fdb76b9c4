// SPDX-License-Identifier: Apache-2.0
#include "covis/geometry/depth_noise.h"

#include <gtest/gtest.h>

#include "covis/geometry/camera.h"

namespace covis {
namespace {

TEST(DepthNoise, ItsReachIsWhereItsShareIsWhatWasAsked) {
  for (const DepthNoise& noise : {DepthNoise::kinect(), DepthNoise::realsense(), DepthNoise::exact()}) {
    ASSERT_TRUE(noise.known());
    const double z = noise.reach(0.01);
    EXPECT_NEAR(noise.sigma(z), 0.01 * z, 1e-9);
    EXPECT_GT(noise.sigma(1.1 * z), 0.011 * z);
  }
  EXPECT_EQ((DepthNoise{0.1, 0.1}.reach(0.01)), 0) << "nowhere";
  EXPECT_FALSE(DepthNoise{}.known());
}

TEST(DepthNoise, CloseIsByTheNoiseOfADepthSensorAndByTheBaselineOfStereo) {
  const CloseDepth close{.baselines = 30, .noise = 0.005};
  Pinhole camera{500, 500, 320, 240, 50};
  EXPECT_DOUBLE_EQ(close.metres(camera), 3);
  camera.depth_noise = DepthNoise::kinect();
  EXPECT_DOUBLE_EQ(close.metres(camera), DepthNoise::kinect().reach(0.005));
}

}  // namespace
}  // namespace covis
