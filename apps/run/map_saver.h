// SPDX-License-Identifier: Apache-2.0
// Saves the map of a run aside while the run goes on, so that a process that is killed loses minutes and not all of it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <future>
#include <string>

#include "covis/core/error.h"
#include "covis/core/time.h"
#include "covis/slam/system.h"
#include "covis/storage/map_file.h"

namespace covis::app {

// The interval between two savings: `frames` of them, or seconds if that is 0; both 0: never.
struct SaveInterval {
  int64_t frames = 0;
  double seconds = 0;
  friend bool operator==(const SaveInterval&, const SaveInterval&) = default;
};

// Reads "120s" (seconds) or "500" (frames); "0" is never.
Result<SaveInterval> parse_save_interval(const std::string& text);

// FILE.unfinished beside the file that the map goes to at the run's end.
std::filesystem::path unfinished_map(const std::filesystem::path& file);

// Says before a run whether its map can be saved to the file, and to the one aside; warns of a map that an earlier run
// left aside. `interval`: never means that nothing is saved aside.
Result<void> check_map_target(const std::filesystem::path& file, const SaveInterval& interval);

// A thread of its own compresses and writes, at half the weight of others. The map itself is never changed, and the run
// waits only for a copy of its lists: results do not depend on savings.
class MapSaver {
 public:
  MapSaver(const std::filesystem::path& file, const storage::MapHeader& header, const SaveInterval& interval)
      : aside_(unfinished_map(file)), header_(header), interval_(interval) {}
  // Called after each frame: saves when that is due and the last saving is done. A saving that fails is warned of.
  void frame_done(const System& system);
  // The map is saved where it belongs: waits for the last saving and removes the file aside.
  void finish();

 private:
  bool is_due() const;
  void take_result();

  std::filesystem::path aside_;
  storage::MapHeader header_;
  SaveInterval interval_;
  int64_t frames_ = 0;  // number of frames since the last saving
  Stopwatch since_;
  std::future<Result<void>> saving_;
  bool warned_ = false;
};

}  // namespace covis::app
