// SPDX-License-Identifier: Apache-2.0
#include "apps/run/run_loop.h"

#include <exception>
#include <optional>
#include <string>
#include <utility>

#include "apps/run/activity.h"
#include "apps/run/key_frame_pictures.h"
#include "apps/run/pace.h"
#include "apps/run/progress.h"
#include "apps/run/resources.h"
#include "apps/run/system_input.h"
#include "apps/view/loop_history.h"
#include "covis/core/failure_reason.h"
#include "covis/core/log.h"

namespace covis::app {
namespace {

constexpr size_t kMemoryEvery = 100;  // interval of the memory measurements, frames

void skip(FrameStats stats, RunObserver* observer, RunRecord& run) {
  if (observer) observer->frame_skipped(stats);
  run.frames.push_back(std::move(stats));
}

// Records a frame that can't be had, and says why; returns false where there will be no other.
bool pass_over(const Error& error, const io::LiveStatus& live, int64_t frame, RunObserver* observer, RunRecord& run) {
  log(LogLevel::warning, error.message);
  const bool failed = live.state == io::LiveStatus::State::failed;
  if (failed) run.failure = error.message;
  skip(skipped_frame(frame, 0,
                     live.state == io::LiveStatus::State::gone ? FrameState::camera_gone : FrameState::unreadable,
                     error.message),
       observer, run);
  return !failed;
}

// Keeps what mapping reported.
void add_mapping(const std::vector<MappingReport>& reports, const System& system, view::LoopHistory& history,
                 RunObserver* observer, RunRecord& run) {
  run.mapping.insert(run.mapping.end(), reports.begin(), reports.end());
  if (history.look(system.map(), reports) == view::LoopHistory::Change::none) return;
  run.loops = history.loops();
  if (observer) observer->loops_changed(run.loops);
}

void add_warnings(const std::vector<SensorWarning>& warnings, RunRecord& run) {
  run.warnings.insert(run.warnings.end(), warnings.begin(), warnings.end());
}

// Partners of the loop over frames.
struct Beside {
  view::LoopHistory& history;
  KeyFrameColouring* colouring;  // may be null
  int64_t& at;                   // index of the frame
};

void track_frames(io::Sequence& sequence, System& system, const PlayOptions& options, const Beside& beside,
                  RunRecord& run) {
  Progress progress(options.show_progress ? sequence.size() : Progress::kHidden);
  std::optional<Stopwatch> since_first;
  Pace pace(*options.stop);
  const double frame_seconds = 1 / sequence.frame_rate();
  io::Frame frame;
  int64_t expected = options.first;
  while (*options.stop == 0) {
    const Stopwatch decode;
    beside.at = expected;
    enter_frame(expected);
    Result<std::optional<io::Frame>> next = sequence.next(std::move(frame));
    frame = {};
    const io::LiveStatus live = sequence.live();
    run.dropped = live.dropped;
    if (!next) {
      if (!pass_over(next.error(), live, expected, options.observer, run)) break;
      progress.show(name(run.frames.back().state), run.frames.size(), system.map_size(), live.dropped);
      expected += options.stride;
      continue;
    }
    if (!*next) break;
    if (!run.frames.empty() && run.frames.back().state == FrameState::camera_gone)
      log(LogLevel::info, "the camera is back");
    frame = std::move(**next);
    beside.at = frame.index;
    expected = frame.index + options.stride;
    const double decode_ms = decode.ms();
    if (!since_first) since_first.emplace();
    if (options.pacing == Pacing::recorded && pace.wait_until_due(frame.stamp, frame_seconds) == Due::late) {
      skip(skipped_frame(frame.index, frame.stamp, FrameState::late,
                         "the next frame was due before this one could be taken"),
           options.observer, run);
      continue;
    }
    const double cpu_start = thread_cpu_ms();
    const FrameReport report = system.process(input_of(frame));
    if (run.first_pose_ms < 0 && report.track.state == TrackingState::tracking) run.first_pose_ms = since_first->ms();
    add_mapping(report.mapping, system, beside.history, options.observer, run);
    add_warnings(report.warnings, run);
    FrameStats stats = tracked_frame(frame, report, options.mode);
    stats.decode_ms = decode_ms;
    if (options.observer) options.observer->frame_tracked(stats, frame, report);
    stats.cpu_ms = thread_cpu_ms() - cpu_start;
    if (run.frames.size() % kMemoryEvery == 0) stats.rss_mb = resident_mb();
    run.frames.push_back(std::move(stats));
    if (beside.colouring && report.track.key_frame) beside.colouring->wake();
    if (options.saver) options.saver->frame_done(system);
    progress.show(name(run.frames.back().state), run.frames.size(), system.map_size(), live.dropped);
  }
}

}  // namespace

void track_all(io::Sequence& sequence, System& system, const PlayOptions& options, RunRecord& run) {
  const Stopwatch wall;
  if (options.observer) options.observer->run_begins(system);
  view::LoopHistory history;
  std::optional<KeyFrameColouring> colouring;
  if (options.colours) colouring.emplace(sequence, system);
  int64_t at = options.first;
  try {
    track_frames(sequence, system, options, {history, colouring ? &*colouring : nullptr, at}, run);
    add_mapping(system.finish(), system, history, options.observer, run);
    add_warnings(system.take_warnings(), run);
    if (colouring) colouring->finish();
  } catch (const std::exception& error) {  // as a lack of memory, in whichever thread
    run.failure = "frame " + std::to_string(at) + ": the run ends here: " + std::string(reason_of(error));
  }
  enter_part("at the end of the recording");
  settle_states(*system.snapshot(), options.mode, run.frames);
  run.notes = sequence.notes();
  run.wall_seconds = wall.ms() / 1000;
  run.interrupted = *options.stop != 0;
}

}  // namespace covis::app
