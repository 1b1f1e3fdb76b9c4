// SPDX-License-Identifier: Apache-2.0
// Lets recorded frames come at their own times.
#pragma once

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <optional>

#include "covis/core/time.h"

namespace covis::app {

class Pace {
 public:
  // Waits until the frame is due, or the command is interrupted. True when it is late by more than the time to the next
  // one: a camera would have gone on.
  bool wait_until_due(Timestamp stamp, double frame_seconds);

 private:
  using Clock = std::chrono::steady_clock;
  std::optional<Clock::time_point> start_;
  Timestamp first_ = 0;
  std::mutex mutex_;
  std::condition_variable waiting_;
};

}  // namespace covis::app
