// SPDX-License-Identifier: Apache-2.0
#include "covis/tracking/tracking_options.h"

#include <gtest/gtest.h>

#include <set>
#include <string>

namespace covis {
namespace {

TEST(TrackingOptions, EverySettingHasANameOfItsOwn) {
  TrackerOptions options;
  std::set<std::string> names;
  for (const auto& field : fields(options)) {
    EXPECT_EQ(field.name.rfind("tracker.", 0), 0u) << field.name;
    EXPECT_TRUE(names.insert(field.name).second) << field.name;
  }
  constexpr size_t kNumbers = 1 + 6 + 7 + 4 + 11 + 7;  // shutter, first pose, local map, recovery, key frame, start
  EXPECT_EQ(names.size(), kNumbers);
}

TEST(TrackingOptions, WindowsDependOnTheSensor) {
  const FirstPoseOptions first;
  EXPECT_EQ(first.window(Sensor::monocular), first.motion_window);
  EXPECT_EQ(first.window(Sensor::rgbd), first.motion_window);
  EXPECT_EQ(first.window(Sensor::stereo), first.motion_window_stereo);
  const LocalMapOptions local;
  EXPECT_EQ(local.window_factor(Sensor::monocular), 1);
  EXPECT_EQ(local.window_factor(Sensor::stereo), 1);
  EXPECT_EQ(local.window_factor(Sensor::rgbd), local.local_window_rgbd);
}

}  // namespace
}  // namespace covis
