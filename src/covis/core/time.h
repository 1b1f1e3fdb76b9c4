// SPDX-License-Identifier: Apache-2.0
// Frame timestamps and a stopwatch. Timestamps are integer nanoseconds: EuRoC's 19 digits do not fit a double.
#pragma once

#include <chrono>
#include <cstdint>

namespace covis {

using Timestamp = int64_t;  // nanoseconds since the recording's epoch

constexpr double to_seconds(Timestamp t) { return static_cast<double>(t) * 1e-9; }
constexpr Timestamp from_seconds(double s) { return static_cast<Timestamp>(s * 1e9 + (s < 0 ? -0.5 : 0.5)); }

class Stopwatch {
 public:
  // Returns the milliseconds since construction or the last restart().
  double ms() const { return std::chrono::duration<double, std::milli>(Clock::now() - start_).count(); }
  void restart() { start_ = Clock::now(); }
  // The same milliseconds; restarts.
  double lap() {
    const double since = ms();
    restart();
    return since;
  }

 private:
  using Clock = std::chrono::steady_clock;
  Clock::time_point start_ = Clock::now();
};

}  // namespace covis
