// SPDX-License-Identifier: Apache-2.0
// The loop of `covis run`: every frame of a recording through the system, with a record of each.
#pragma once

#include <atomic>

#include "apps/run/run_record.h"

namespace covis::app {

// recorded: frames come at their own times, and late ones are dropped; free: as fast as they are processed.
enum class Pacing { free, recorded };

struct LoopOptions {
  int64_t first = 0;  // index of the first frame
  int stride = 1;
  Pacing pacing = Pacing::free;
  RunMode mode = RunMode::mapping;
  bool show_progress = true;
  const std::atomic<int>* stop = nullptr;  // ends the loop when it is not zero
};

// Fills frames, mapping, times and `interrupted` of the record.
void track_all(io::Sequence& sequence, System& system, const LoopOptions& options, RunRecord& run);

}  // namespace covis::app
