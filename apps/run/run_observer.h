// SPDX-License-Identifier: Apache-2.0
// Watches a run while it goes on. All calls come from the tracking thread, which waits for them.
#pragma once

#include <vector>

#include "apps/run/run_record.h"
#include "covis/io/sequence.h"
#include "covis/slam/system.h"

namespace covis::app {

class RunObserver {
 public:
  virtual ~RunObserver() = default;
  // The system has the last of these frames behind it.
  virtual void run_begins(const System& system) = 0;
  virtual void frame_tracked(const FrameStats& stats, const io::Frame& frame, const FrameReport& report) = 0;
  // Late or unreadable, or the camera went away.
  virtual void frame_skipped(const FrameStats& stats) = 0;
  virtual void loops_changed(const std::vector<view::LoopPaths>& loops) = 0;
};

}  // namespace covis::app
