// SPDX-License-Identifier: Apache-2.0
// For tests: a second process.
#pragma once

#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <system_error>
#include <thread>

namespace covis {

// fork(), tried for up to five seconds where the machine is so busy that it has no room for a process at the moment.
// Throws std::system_error when there is none.
inline pid_t fork_patiently() {
  pid_t id = fork();
  for (int tries = 1; id < 0 && errno == EAGAIN && tries < 50; ++tries) {
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    id = fork();
  }
  if (id < 0) throw std::system_error(errno, std::generic_category(), "fork");
  return id;
}

}  // namespace covis
