// SPDX-License-Identifier: Apache-2.0
// The viewer's knowledge of a run beside the map: its frames, the reasons for missing poses, and its loops. Frames and
// reasons only grow, so that a client need know no more than how many it has.
#pragma once

#include <cstdint>
#include <string>
#include <unordered_map>
#include <vector>

#include "apps/view/rows.h"

namespace covis::view {

class RunLog {
 public:
  RunLog() : texts_{""} {}

  // reason: in words; empty: none. A run with more than 65535 different reasons keeps the first of them.
  void add(FrameRow row, const std::string& reason);
  // All loops so far. Those known already may have moved: a full adjustment follows a loop.
  void set_loops(const std::vector<LoopPaths>& loops);
  // The next text, in a log that is read back.
  void add_text(std::string text);
  void add_row(const FrameRow& row) { frames_.push_back(row); }

  const std::vector<FrameRow>& frames() const { return frames_; }
  const std::vector<std::string>& texts() const { return texts_; }
  const std::vector<LoopPaths>& loops() const { return loops_; }
  // For each loop how often it was set to something new.
  const std::vector<uint32_t>& loop_versions() const { return loop_versions_; }

 private:
  std::vector<FrameRow> frames_;
  std::vector<std::string> texts_;  // the first is empty
  std::unordered_map<std::string, uint16_t> index_of_text_;
  std::vector<LoopPaths> loops_;
  std::vector<uint32_t> loop_versions_;
};

}  // namespace covis::view
