// SPDX-License-Identifier: Apache-2.0
#include "covis/core/threads.h"

#ifdef __linux__
#include <pthread.h>
#include <sched.h>
#include <sys/resource.h>
#endif

namespace covis {

#ifdef __linux__

// Errors are ignored: the priority or core mask then stays unchanged.

void lower_thread_priority() {
  constexpr int kSteps = 3;
  // Linux keeps a nice value per thread; 0 selects the calling thread.
  setpriority(PRIO_PROCESS, 0, getpriority(PRIO_PROCESS, 0) + kSteps);
}

void OtherCores::keep(std::jthread& helper) {
  const int core = sched_getcpu();
  if (core == core_) return;
  core_ = core;
  cpu_set_t others;
  CPU_ZERO(&others);
  if (core < 0 || pthread_getaffinity_np(pthread_self(), sizeof others, &others) != 0) return;
  if (CPU_COUNT(&others) > 1) CPU_CLR(core, &others);
  pthread_setaffinity_np(helper.native_handle(), sizeof others, &others);
}

#else

void lower_thread_priority() {}
void OtherCores::keep(std::jthread&) {}

#endif

}  // namespace covis
