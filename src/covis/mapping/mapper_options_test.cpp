// SPDX-License-Identifier: Apache-2.0
#include "covis/mapping/mapper_options.h"

#include <gtest/gtest.h>

#include <set>
#include <string>

namespace covis {
namespace {

TEST(MapperOptions, EverySettingHasANameOfItsOwn) {
  MapperOptions options;
  std::set<std::string> names;
  for (const Field& field : fields(options)) {
    EXPECT_EQ(field.name.rfind("mapper.", 0), 0u) << field.name;
    EXPECT_TRUE(names.insert(field.name).second) << field.name;
  }
  EXPECT_EQ(names.size(), 15u);
}

TEST(MapperOptions, OneCameraAsksMoreNeighbours) {
  const MapperOptions options;
  EXPECT_EQ(options.neighbours(Sensor::monocular), options.create_neighbours_mono);
  EXPECT_EQ(options.neighbours(Sensor::stereo), options.create_neighbours);
  EXPECT_EQ(options.neighbours(Sensor::rgbd), options.create_neighbours);
}

}  // namespace
}  // namespace covis
