// SPDX-License-Identifier: Apache-2.0
// How far a run is.
#pragma once

#include <cstdint>
#include <string>

#include "covis/core/time.h"

namespace covis::app {

// A line on stderr that renews itself; on a terminal only.
class Progress {
 public:
  Progress(bool quiet, int64_t total);  // total: frames; -1: not known
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  void show(const std::string& state, size_t done, size_t key_frames, size_t points);

 private:
  const bool shown_;
  const int64_t total_;
  Stopwatch all_, since_;
};

}  // namespace covis::app
