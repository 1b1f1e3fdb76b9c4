// SPDX-License-Identifier: Apache-2.0
#include "apps/run/map_saver.h"

#include <algorithm>
#include <charconv>
#include <chrono>
#include <exception>
#include <system_error>
#include <utility>

#include "covis/core/failure_reason.h"
#include "covis/core/log.h"
#include "covis/core/threads.h"
#include "covis/io/files.h"

namespace covis::app {

Result<SaveInterval> parse_save_interval(const std::string& text) {
  const bool seconds = text.ends_with('s');
  const char* const end = text.data() + text.size() - (seconds ? 1 : 0);
  SaveInterval interval;
  const auto read = seconds ? std::from_chars(text.data(), end, interval.seconds)
                            : std::from_chars(text.data(), end, interval.frames);
  const bool sensible = interval.frames >= 0 && interval.seconds >= 0 && interval.seconds < 1e9;  // a NaN is not
  if (read.ec != std::errc() || read.ptr != end || !sensible)
    return fail("--save-every " + text + ": a number of frames (500), of seconds (120s) or 0 (never) is wanted");
  return interval;
}

std::filesystem::path unfinished_map(const std::filesystem::path& file) {
  std::filesystem::path aside = file;
  aside += ".unfinished";
  return aside;
}

std::filesystem::path older_unfinished_map(const std::filesystem::path& file) {
  std::filesystem::path older = unfinished_map(file);
  older += ".old";
  return older;
}

bool comes_with_results(const std::filesystem::path& file, const std::filesystem::path& results) {
  std::error_code none;
  if (file.parent_path().empty() || std::filesystem::exists(file.parent_path(), none)) return false;
  const std::filesystem::path folder = io::normal_path(file.parent_path()), made = io::normal_path(results);
  return std::mismatch(folder.begin(), folder.end(), made.begin(), made.end()).first == folder.end();
}

Result<void> check_map_target(const std::filesystem::path& file, const SaveInterval& interval) {
  if (auto fits = storage::check_save_target(file); !fits) return fits;
  std::error_code none;
  const auto no_file = [&](const std::filesystem::path& path) {
    return std::filesystem::exists(path, none) && !std::filesystem::is_regular_file(path, none);
  };
  if (interval == SaveInterval{} || no_file(file)) return {};  // a pipe or a device has nothing aside
  const std::filesystem::path aside = unfinished_map(file), older = older_unfinished_map(file);
  for (const std::filesystem::path& path : {aside, older}) {
    if (no_file(path))
      return fail(path.string() +
                  ": the map is saved aside there while it is made, but it is no regular file; remove it");
    if (auto fits = storage::check_save_target(path); !fits) return fits;
    if (!std::filesystem::exists(aside, none)) return {};
  }
  log(LogLevel::warning, aside.string() +
                             ": it is the map of a run that did not end well. Before this run saves there, "
                             "it is renamed to " +
                             older.filename().string());
  return {};
}

bool MapSaver::is_due() const {
  if (interval_.frames > 0) return frames_ >= interval_.frames;
  return interval_.seconds > 0 && since_.ms() >= 1000 * interval_.seconds;
}

void MapSaver::warn(const std::string& why) {
  if (warned_) return;
  warned_ = true;
  log(LogLevel::warning, "the map could not be saved aside: " + why);
}

void MapSaver::take_result() {
  if (!saving_.valid()) return;
  try {
    if (const Result<void> saved = saving_.get(); !saved) warn(saved.error().message);
  } catch (const std::exception& error) {  // as a lack of memory
    warn(std::string(reason_of(error)));
  }
}

// Runs on the thread that saves.
Result<void> MapSaver::save(const MapState& map) {
  lower_thread_priority();
  std::error_code error;
  if (!owned_ && std::filesystem::exists(aside_, error)) {
    std::filesystem::rename(aside_, older_, error);
    if (error) return fail(aside_.string() + ": it can't be renamed to " + older_.string() + ": " + error.message());
  }
  owned_ = true;
  auto saved = storage::save_map(aside_, map, header_);
  wrote_ = wrote_ || saved;
  return saved;
}

void MapSaver::begin_saving(const System& system) {
  try {
    saving_ = std::async(std::launch::async, [this, map = system.map_state()] { return save(map); });
  } catch (const std::exception& error) {  // as no thread to be had
    warn(std::string(reason_of(error)));
  }
}

void MapSaver::frame_done(const System& system) {
  ++frames_;
  if (!is_due()) return;
  if (saving_.valid() && saving_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) return;
  take_result();
  frames_ = 0;
  since_ = Stopwatch();
  if (system.map_size().key_frames > 0) begin_saving(system);
}

void MapSaver::finish() {
  take_result();
  std::error_code none;
  if (wrote_) std::filesystem::remove(aside_, none);
}

Result<void> save_map(const std::filesystem::path& file, const MapState& map, const storage::MapHeader& header,
                      std::optional<MapSaver>& saver) {
  if (map.key_frames.empty()) {
    log(LogLevel::warning, file.string() + ": there is no map to save, so that nothing is written there");
    return {};
  }
  auto saved = storage::save_map(file, map, header);
  if (saved && saver) saver->finish();
  return saved;
}

}  // namespace covis::app
