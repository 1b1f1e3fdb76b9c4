// SPDX-License-Identifier: Apache-2.0
// Whole runs that save aside are tests/command_save_test.cpp's.
#include "apps/run/map_saver.h"

#include <gmock/gmock.h>
#include <sys/stat.h>

#include "covis/core/test_folder.h"

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

TEST(MapSaver, WhereAMapIsSavedAsideThereMustBeAFileOrNothing) {
  const TemporaryFolder folder;
  EXPECT_TRUE(check_map_target(folder / "m", {.frames = 5}));
  ASSERT_EQ(mkfifo((folder / "m.unfinished").c_str(), 0600), 0);
  EXPECT_THAT(check_map_target(folder / "m", {.frames = 5}).error().message,
              testing::HasSubstr("m.unfinished: the map is saved aside there while it is made, but it is no regular"));
  EXPECT_TRUE(check_map_target(folder / "m", {})) << "nothing is saved aside";
}

}  // namespace
}  // namespace covis::app
