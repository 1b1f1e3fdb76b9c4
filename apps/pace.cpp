// SPDX-License-Identifier: Apache-2.0
#include "pace.h"

#include <algorithm>

#include "common.h"

namespace covis::app {

bool Pace::wait_until_due(Timestamp stamp, double frame_seconds) {
  const auto now = Clock::now();
  if (!start_) {
    start_ = now;
    first_ = stamp;
  }
  const auto due = *start_ + std::chrono::nanoseconds(stamp - first_);
  if (now > due + std::chrono::duration<double>(frame_seconds)) return true;
  std::unique_lock lock(mutex_);
  // Nobody notifies: a signal or the due time ends the wait.
  while (!interrupted && Clock::now() < due)
    waiting_.wait_until(lock, std::min(due, Clock::now() + std::chrono::milliseconds(100)));
  return false;
}

}  // namespace covis::app
