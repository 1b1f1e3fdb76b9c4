// SPDX-License-Identifier: Apache-2.0
// Whole runs that save aside are tests/command_save_test.cpp's.
#include "apps/run/map_saver.h"

#include <gmock/gmock.h>

namespace covis::app {
namespace {

TEST(MapSaver, IntervalsAreFramesOrSeconds) {
  EXPECT_EQ(parse_save_interval("500"), (SaveInterval{.frames = 500}));
  EXPECT_EQ(parse_save_interval("1.5s"), (SaveInterval{.seconds = 1.5}));
  EXPECT_EQ(parse_save_interval("0"), SaveInterval{});
  EXPECT_EQ(parse_save_interval("0s"), SaveInterval{});
  for (const char* const wrong :
       {"", "s", "-1", "-1s", "nans", "infs", "1e300s", "5 s", "5m", "1.5", "99999999999999999999"}) {
    const auto parsed = parse_save_interval(wrong);
    ASSERT_FALSE(parsed) << wrong;
    EXPECT_THAT(parsed.error().message, testing::HasSubstr("--save-every " + std::string(wrong) + ": a number of"));
  }
}

}  // namespace
}  // namespace covis::app
