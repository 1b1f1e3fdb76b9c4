// SPDX-License-Identifier: Apache-2.0
// The loop of `covis run`: passes every frame of a recording to the system and records the results.
#pragma once

#include <atomic>

#include "apps/run/map_saver.h"
#include "apps/run/run_observer.h"
#include "apps/run/run_record.h"

namespace covis::app {

// recorded: frames are processed at their own times, and late ones are dropped; free: as fast as possible.
enum class Pacing { free, recorded };

// Selects the frames that are processed, and how.
struct PlayOptions {
  int64_t first = 0;  // index of the first frame
  int stride = 1;
  Pacing pacing = Pacing::free;
  RunMode mode = RunMode::mapping;
  bool show_progress = true;
  bool colours = true;                     // key frames get the colours of the recording's images
  const std::atomic<int>* stop = nullptr;  // ends the loop when it is not zero
  RunObserver* observer = nullptr;         // may be null
  MapSaver* saver = nullptr;               // saves the map aside meanwhile; may be null
};

// Fills frames, mapping, loops, times and `interrupted` of the record.
void track_all(io::Sequence& sequence, System& system, const PlayOptions& options, RunRecord& run);

}  // namespace covis::app
