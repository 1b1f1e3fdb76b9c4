// SPDX-License-Identifier: Apache-2.0
// Progress display of a run.
#pragma once

#include <cstdint>
#include <string_view>

#include "covis/core/time.h"

namespace covis::app {

// A line on stderr that is updated in place; on a terminal only.
class Progress {
 public:
  static constexpr int64_t kUnknown = -1, kHidden = -2;
  explicit Progress(int64_t total);  // total: number of frames, kUnknown or kHidden
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  void show(std::string_view state, size_t done, size_t key_frames, size_t points);

 private:
  const bool shown_;
  const int64_t total_;
  Stopwatch all_, since_;
};

}  // namespace covis::app
