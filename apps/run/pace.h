// SPDX-License-Identifier: Apache-2.0
// Plays recorded frames at their own times.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <optional>

#include "covis/core/time.h"

namespace covis::app {

// late: by more than one frame interval; a live camera would have delivered the next frame.
enum class Due { in_time, late };

class Pace {
 public:
  // Waiting ends early when `stop` is not zero.
  explicit Pace(const std::atomic<int>& stop) : stop_(stop) {}
  // Waits until the frame is due, relative to the first call.
  Due wait_until_due(Timestamp stamp, double frame_seconds);

 private:
  using Clock = std::chrono::steady_clock;
  const std::atomic<int>& stop_;
  std::optional<Clock::time_point> start_;
  Timestamp first_ = 0;
  std::mutex mutex_;
  std::condition_variable waiting_;
};

}  // namespace covis::app
