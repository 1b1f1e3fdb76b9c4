// SPDX-License-Identifier: Apache-2.0
// Which threads get a core, and which one, when there are more busy threads than cores. Only where threads have
// priorities and cores of their own (Linux); elsewhere nothing happens.
#pragma once

#include <thread>

namespace covis {

// For work that gives way to tracking: from now on the calling thread, and those it makes, get half the time of a
// thread of usual priority they share a core with; all of it when the core is free.
void lower_thread_priority();

// Keeps a helper off the core its caller runs on. Where cores share no cache Linux may wake it there, to wait until the
// caller is done, while others are idle or do work of lower priority.
class OtherCores {
 public:
  // Call it in the caller's thread, before the helper is woken. The helper may then use the caller's cores but the
  // present one; that one too when it is the only one.
  void keep(std::jthread& helper);

 private:
  int core_ = -1;  // the caller's core the last time
};

}  // namespace covis
