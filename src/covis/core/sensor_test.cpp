// SPDX-License-Identifier: Apache-2.0
#include "covis/core/sensor.h"

#include <gtest/gtest.h>

namespace covis {
namespace {

// Scripts and settings know them by these names.
TEST(Sensor, NamesStay) {
  EXPECT_EQ(name(Sensor::monocular), "mono");
  EXPECT_EQ(name(Sensor::stereo), "stereo");
  EXPECT_EQ(name(Sensor::rgbd), "rgbd");
}

}  // namespace
}  // namespace covis
