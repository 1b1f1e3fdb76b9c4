// SPDX-License-Identifier: Apache-2.0
#include "covis/core/thread_priority.h"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <thread>

namespace covis {
namespace {

TEST(ThreadPriority, IsLoweredForTheCallingThreadAlone) {
#ifndef __linux__
  GTEST_SKIP() << "threads have no priorities of their own here";
#endif
  const int usual = getpriority(PRIO_PROCESS, 0);
  if (usual > 10) GTEST_SKIP() << "already low";
  int lowered = usual;
  std::thread([&] {
    lower_thread_priority();
    lowered = getpriority(PRIO_PROCESS, 0);
  }).join();
  EXPECT_GT(lowered, usual);
  EXPECT_EQ(getpriority(PRIO_PROCESS, 0), usual);
}

}  // namespace
}  // namespace covis
