// SPDX-License-Identifier: Apache-2.0
// Saves the map of a run aside while the run goes on, so that a process that is killed loses minutes and not all of it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <future>
#include <optional>
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

// FILE.unfinished.old: the first saving of a run puts there what an earlier run left aside.
std::filesystem::path older_unfinished_map(const std::filesystem::path& file);

// The file's folder is not there yet, and will be once that of the results is made.
bool comes_with_results(const std::filesystem::path& file, const std::filesystem::path& results);

// Says before a run whether its map can be saved to the file, and to those aside; warns of a map that an earlier run
// left aside. `interval`: never means that nothing is saved aside.
Result<void> check_map_target(const std::filesystem::path& file, const SaveInterval& interval);

// A thread of its own compresses and writes, at half the weight of others. The map itself is never changed, and the run
// waits only for a copy of its lists: results do not depend on savings.
class MapSaver {
 public:
  MapSaver(const std::filesystem::path& file, const storage::MapHeader& header, const SaveInterval& interval)
      : aside_(unfinished_map(file)), older_(older_unfinished_map(file)), header_(header), interval_(interval) {}
  MapSaver(const MapSaver&) = delete;
  MapSaver& operator=(const MapSaver&) = delete;
  // Called after each frame: saves when that is due and the last saving is done. A saving that fails is warned of; the
  // run goes on.
  void frame_done(const System& system);
  // The map is saved where it belongs: waits for the last saving and removes the file aside, if this run wrote it.
  void finish();

 private:
  bool is_due() const;
  void begin_saving(const System& system);
  Result<void> save(const MapState& map);
  void take_result();
  void warn(const std::string& why);

  std::filesystem::path aside_, older_;
  storage::MapHeader header_;
  SaveInterval interval_;
  int64_t frames_ = 0;  // number of frames since the last saving
  Stopwatch since_;
  bool warned_ = false;
  bool owned_ = false, wrote_ = false;  // the file aside is this run's to write; this run wrote it
  std::future<Result<void>> saving_;    // the last, as it is waited for before all else goes
};

// Saves the map of a run at its end, and removes what was saved aside. A map of nothing is not worth an older file, and
// could not be continued either: it is a warning.
Result<void> save_map(const std::filesystem::path& file, const MapState& map, const storage::MapHeader& header,
                      std::optional<MapSaver>& saver);

}  // namespace covis::app
