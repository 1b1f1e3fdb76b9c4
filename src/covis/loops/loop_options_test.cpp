// SPDX-License-Identifier: Apache-2.0
#include "covis/loops/loop_options.h"

#include <gtest/gtest.h>

#include <set>
#include <string>

namespace covis {
namespace {

TEST(LoopOptions, EverySettingHasANameOfItsOwn) {
  LoopOptions options;
  std::set<std::string> names;
  for (const Field& field : fields(options)) {
    EXPECT_EQ(field.name.rfind("loop.", 0), 0u) << field.name;
    EXPECT_TRUE(names.insert(field.name).second) << field.name;
  }
  EXPECT_EQ(names.size(), 14u);
}

TEST(LoopOptions, MergingAsksForNoDrift) {
  LoopOptions options;
  std::set<std::string> names;
  for (const Field& field : merge_fields(options)) names.insert(field.name);
  EXPECT_EQ(names.size(), 7u);
  EXPECT_TRUE(names.contains("loop.merge_min_found"));
  EXPECT_FALSE(names.contains("loop.max_drift"));
}

TEST(LoopOptions, OneCameraMayDriftMore) {
  const LoopOptions options;
  EXPECT_EQ(options.drift(Sensor::monocular), options.max_drift_mono);
  EXPECT_EQ(options.drift(Sensor::stereo), options.max_drift);
  EXPECT_EQ(options.drift(Sensor::rgbd), options.max_drift);
  EXPECT_GT(options.drift(Sensor::monocular), options.drift(Sensor::rgbd));
}

}  // namespace
}  // namespace covis
