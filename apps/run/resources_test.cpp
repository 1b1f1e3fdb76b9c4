// SPDX-License-Identifier: Apache-2.0
#include "apps/run/resources.h"

#include <gtest/gtest.h>

#include <vector>

namespace covis::app {
namespace {

TEST(Resources, MemoryThatIsTouchedIsCounted) {
  const double before = resident_mb();
  EXPECT_GT(before, 0.5);
  std::vector<char> touched(64 << 20, 'x');
  EXPECT_GT(resident_mb(), before + 40);
  EXPECT_GE(peak_rss_mb(), before + 40);
  EXPECT_EQ(touched.back(), 'x');
}

TEST(Resources, ProcessorTimeGrowsWithWorkAlone) {
  const double start = thread_cpu_ms();
  double sum = 0;
  while (thread_cpu_ms() < start + 5) sum += 1;
  EXPECT_GT(sum, 0);
}

}  // namespace
}  // namespace covis::app
