// SPDX-License-Identifier: Apache-2.0
#include "apps/run/map_saver.h"

#include <charconv>
#include <chrono>
#include <cmath>
#include <system_error>
#include <utility>

#include "covis/core/log.h"
#include "covis/core/threads.h"

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

Result<void> check_map_target(const std::filesystem::path& file, const SaveInterval& interval) {
  if (auto fits = storage::check_save_target(file); !fits) return fits;
  std::error_code none;
  // A pipe or a device has nothing aside.
  if (interval == SaveInterval{} ||
      (std::filesystem::exists(file, none) && !std::filesystem::is_regular_file(file, none)))
    return {};
  const std::filesystem::path aside = unfinished_map(file);
  if (auto fits = storage::check_save_target(aside); !fits) return fits;
  if (std::filesystem::exists(aside, none)) {
    log(LogLevel::warning, aside.string() +
                               ": it is the map of a run that did not end well. This run will replace it; "
                               "to keep it, end this run and rename it");
  }
  return {};
}

bool MapSaver::is_due() const {
  if (interval_.frames > 0) return frames_ >= interval_.frames;
  return interval_.seconds > 0 && since_.ms() >= 1000 * interval_.seconds;
}

void MapSaver::take_result() {
  if (!saving_.valid()) return;
  const Result<void> saved = saving_.get();
  if (saved || warned_) return;
  warned_ = true;
  log(LogLevel::warning, "the map could not be saved aside: " + saved.error().message);
}

void MapSaver::frame_done(const System& system) {
  ++frames_;
  if (!is_due()) return;
  if (saving_.valid() && saving_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) return;
  take_result();
  frames_ = 0;
  since_ = Stopwatch();
  if (system.map_size().key_frames == 0) return;
  saving_ = std::async(std::launch::async, [state = system.map_state(), file = aside_, header = header_] {
    lower_thread_priority();
    return storage::save_map(file, state, header);
  });
}

void MapSaver::finish() {
  take_result();
  std::error_code none;
  std::filesystem::remove(aside_, none);
}

}  // namespace covis::app
