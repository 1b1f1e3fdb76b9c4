// SPDX-License-Identifier: Apache-2.0
#include "apps/run/run_loop.h"

#include <optional>
#include <utility>

#include "apps/run/key_frame_pictures.h"
#include "apps/run/pace.h"
#include "apps/run/progress.h"
#include "apps/run/resources.h"
#include "apps/run/system_input.h"
#include "apps/view/loop_history.h"
#include "covis/core/log.h"

namespace covis::app {
namespace {

constexpr size_t kMemoryEvery = 100;  // interval of the memory measurements, frames

void skip(FrameStats stats, RunObserver* observer, RunRecord& run) {
  if (observer) observer->frame_skipped(stats);
  run.frames.push_back(std::move(stats));
}

// Keeps what mapping reported.
void add_mapping(const std::vector<MappingReport>& reports, const System& system, view::LoopHistory& history,
                 RunObserver* observer, RunRecord& run) {
  run.mapping.insert(run.mapping.end(), reports.begin(), reports.end());
  if (history.look(system.map(), reports) == view::LoopHistory::Change::none) return;
  run.loops = history.loops();
  if (observer) observer->loops_changed(run.loops);
}

}  // namespace

void track_all(io::Sequence& sequence, System& system, const PlayOptions& options, RunRecord& run) {
  const Stopwatch wall;
  if (options.observer) options.observer->run_begins(system);
  view::LoopHistory history;
  Progress progress(options.show_progress ? sequence.size() : Progress::kHidden);
  std::optional<Stopwatch> since_first;
  Pace pace(*options.stop);
  std::optional<KeyFrameColouring> colouring;
  if (options.colours) colouring.emplace(sequence, system);
  io::Frame frame;
  int64_t expected = options.first;
  while (*options.stop == 0) {
    const Stopwatch decode;
    Result<std::optional<io::Frame>> next = sequence.next(std::move(frame));
    frame = {};
    if (!next) {
      log(LogLevel::warning, next.error().message);
      skip(skipped_frame(expected, 0, FrameState::unreadable, next.error().message), options.observer, run);
      expected += options.stride;
      continue;
    }
    if (!*next) break;
    frame = std::move(**next);
    expected = frame.index + options.stride;
    const double decode_ms = decode.ms();
    if (!since_first) since_first.emplace();
    if (options.pacing == Pacing::recorded &&
        pace.wait_until_due(frame.stamp, 1.0 / sequence.frame_rate()) == Due::late) {
      skip(skipped_frame(frame.index, frame.stamp, FrameState::late,
                         "the next frame was due before this one could be taken"),
           options.observer, run);
      continue;
    }
    const double cpu_start = thread_cpu_ms();
    const FrameReport report = system.process(input_of(frame));
    if (run.first_pose_ms < 0 && report.track.state == TrackingState::tracking) run.first_pose_ms = since_first->ms();
    add_mapping(report.mapping, system, history, options.observer, run);
    run.warnings.insert(run.warnings.end(), report.warnings.begin(), report.warnings.end());
    FrameStats stats = tracked_frame(frame, report, options.mode);
    stats.decode_ms = decode_ms;
    stats.cpu_ms = thread_cpu_ms() - cpu_start;
    if (run.frames.size() % kMemoryEvery == 0) stats.rss_mb = resident_mb();
    if (options.observer) options.observer->frame_tracked(stats, frame, report);
    run.frames.push_back(std::move(stats));
    if (colouring && report.track.key_frame) colouring->wake();
    const System::MapSize map = system.map_size();
    progress.show(name(run.frames.back().state), run.frames.size(), map.key_frames, map.points);
  }
  add_mapping(system.finish(), system, history, options.observer, run);
  if (colouring) colouring->finish();
  settle_states(*system.snapshot(), options.mode, run.frames);
  run.wall_seconds = wall.ms() / 1000;
  run.interrupted = *options.stop != 0;
}

}  // namespace covis::app
