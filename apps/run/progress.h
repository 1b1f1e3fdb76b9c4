// SPDX-License-Identifier: Apache-2.0
// Progress display of a run.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "covis/core/time.h"
#include "covis/slam/system.h"

namespace covis::app {

// A line on stderr that is updated in place; on a terminal only.
class Progress {
 public:
  static constexpr int64_t kUnknown = -1, kHidden = -2;
  explicit Progress(int64_t total);  // total: number of frames, kUnknown or kHidden
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  // Another state is shown at once, other figures ten times a second. dropped: frames of a live camera.
  void show(std::string_view state, size_t done, const System::MapSize& map, int64_t dropped);

 private:
  const bool shown_;
  const int64_t total_;
  std::string state_;
  Stopwatch all_, since_;
};

}  // namespace covis::app
