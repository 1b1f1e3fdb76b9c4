// SPDX-License-Identifier: Apache-2.0
#include "covis/core/time.h"

#include <gtest/gtest.h>

namespace covis {
namespace {

TEST(Time, StampsSurviveSecondsToTheirPrecision) {
  EXPECT_EQ(from_seconds(1.5), 1'500'000'000);
  EXPECT_EQ(from_seconds(-1.5), -1'500'000'000);
  EXPECT_EQ(from_seconds(0.1 + 0.2), 300'000'000) << "rounded, not cut off";
  EXPECT_EQ(from_seconds(-(0.1 + 0.2)), -300'000'000);
  for (Timestamp t = 0; t < 10'000'000'000; t += 33'333'333) EXPECT_EQ(from_seconds(to_seconds(t)), t);
}

TEST(Time, AStopwatchRunsOnAndStartsAnew) {
  Stopwatch watch;
  double last = watch.ms();
  EXPECT_GE(last, 0);
  for (int i = 0; i < 1000; ++i) {
    const double now = watch.ms();
    ASSERT_GE(now, last);
    last = now;
  }
  while (watch.ms() < 2) {
  }
  const Stopwatch older = watch;
  watch.restart();
  EXPECT_LT(watch.ms(), older.ms());
  while (watch.ms() < 2) {
  }
  EXPECT_GE(watch.lap(), 2);
  EXPECT_LT(watch.ms(), older.ms()) << "a lap begins the next";
}

}  // namespace
}  // namespace covis
