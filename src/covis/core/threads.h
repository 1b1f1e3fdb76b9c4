// SPDX-License-Identifier: Apache-2.0
// Thread priority and core placement for machines with more busy threads than cores. Implemented for Linux, where each
// thread has its own priority and core mask; a no-op elsewhere.
#pragma once

#include <thread>

namespace covis {

// For work that yields to tracking: lowers the priority of the calling thread and of the threads it creates from now
// on. Such a thread gets half the time of a normal thread on the same core, and all of it when the core is otherwise
// idle.
void lower_thread_priority();

// Keeps a helper thread off the core on which its caller runs. Where cores share no cache Linux may wake the helper on
// that core, where it waits until the caller is done although other cores are idle or run work of lower priority.
class OtherCores {
 public:
  // Call it in the caller's thread before waking the helper. The helper may then run on the caller's cores except the
  // current one, or on the current one if there is no other.
  void keep(std::jthread& helper);

 private:
  int core_ = -1;  // core on which the caller ran the last time; -1: unknown
};

}  // namespace covis
