// SPDX-License-Identifier: Apache-2.0
#include "covis/core/threads.h"

#include <gtest/gtest.h>
#ifdef __linux__
#include <sched.h>
#include <sys/resource.h>
#endif

#include <semaphore>

namespace covis {
namespace {

#ifdef __linux__

TEST(Threads, APriorityIsLoweredForTheCallingThreadAlone) {
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

TEST(Threads, AHelperIsKeptOffTheCallersCore) {
  cpu_set_t usual;
  CPU_ZERO(&usual);
  ASSERT_EQ(sched_getaffinity(0, sizeof usual, &usual), 0);
  std::binary_semaphore wake(0), awake(0);
  cpu_set_t allowed;
  std::jthread helper([&] {
    wake.acquire();
    CPU_ZERO(&allowed);
    sched_getaffinity(0, sizeof allowed, &allowed);
    awake.release();
  });
  OtherCores others;
  others.keep(helper);
  wake.release();
  awake.acquire();
  if (CPU_COUNT(&usual) == 1) {
    EXPECT_TRUE(CPU_EQUAL(&allowed, &usual)) << "there is but one core";
  } else {
    EXPECT_EQ(CPU_COUNT(&allowed), CPU_COUNT(&usual) - 1);
  }
}

#endif

}  // namespace
}  // namespace covis
