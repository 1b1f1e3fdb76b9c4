// SPDX-License-Identifier: Apache-2.0
#include "apps/run/pace.h"

#include <algorithm>

namespace covis::app {

Due Pace::wait_until_due(Timestamp stamp, double frame_seconds) {
  const auto now = Clock::now();
  if (!start_) {
    start_ = now;
    first_ = stamp;
  }
  const auto due = *start_ + std::chrono::nanoseconds(stamp - first_);
  if (now > due + std::chrono::duration<double>(frame_seconds)) return Due::late;
  std::unique_lock lock(mutex_);
  // There are no notifications: the due time or `stop` ends the wait.
  while (stop_ == 0 && Clock::now() < due)
    waiting_.wait_until(lock, std::min(due, Clock::now() + std::chrono::milliseconds(100)));
  return Due::in_time;
}

}  // namespace covis::app
