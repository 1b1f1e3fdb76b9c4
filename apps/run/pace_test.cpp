// SPDX-License-Identifier: Apache-2.0
#include "apps/run/pace.h"

#include <gtest/gtest.h>

namespace covis::app {
namespace {

TEST(Pace, WaitsUntilAFrameIsDue) {
  const std::atomic<int> stop = 0;
  Pace pace(stop);
  EXPECT_EQ(pace.wait_until_due(from_seconds(100), 0.01), Due::in_time);
  const Stopwatch watch;
  EXPECT_EQ(pace.wait_until_due(from_seconds(100.02), 10), Due::in_time);
  EXPECT_GT(watch.ms(), 15);
}

TEST(Pace, FramesAfterTheNextOneWasDueAreLate) {
  const std::atomic<int> stop = 0;
  Pace pace(stop);
  EXPECT_EQ(pace.wait_until_due(from_seconds(100), 0.01), Due::in_time);
  EXPECT_EQ(pace.wait_until_due(from_seconds(90), 0.01), Due::late);
  EXPECT_EQ(pace.wait_until_due(from_seconds(90), 60), Due::in_time) << "its successor is not due yet";
}

TEST(Pace, StopsWaitingWhenAsked) {
  const std::atomic<int> stop = 2;
  Pace pace(stop);
  EXPECT_EQ(pace.wait_until_due(from_seconds(0), 1), Due::in_time);
  const Stopwatch watch;
  EXPECT_EQ(pace.wait_until_due(from_seconds(1000), 1), Due::in_time);
  EXPECT_LT(watch.ms(), 10'000);
}

}  // namespace
}  // namespace covis::app
