// SPDX-License-Identifier: Apache-2.0
#include "covis/core/thread_priority.h"

#ifdef __linux__
#include <sys/resource.h>
#endif

namespace covis {

void lower_thread_priority() {
#ifdef __linux__
  // Linux keeps a nice value for each thread; 0 stands for the calling one. An error leaves things as they were.
  constexpr int kSteps = 5;
  setpriority(PRIO_PROCESS, 0, getpriority(PRIO_PROCESS, 0) + kSteps);
#endif
}

}  // namespace covis
