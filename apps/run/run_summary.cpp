// SPDX-License-Identifier: Apache-2.0
#include "apps/run/run_summary.h"

#include <algorithm>
#include <ranges>

#include "covis/core/quantile.h"

namespace covis::app {
namespace {

Spread spread_of(const std::vector<double>& values) { return {quantile(values, 0.5), quantile(values, 0.95)}; }

template <class Items, class Value>
Spread spread(Items&& items, Value value) {
  std::vector<double> values;
  for (const auto& item : items) values.push_back(value(item));
  return spread_of(values);
}

template <class Poses>
Trajectory of_main_submap(const Poses& poses, const Snapshot& snapshot) {
  Trajectory trajectory;
  for (const PoseOfFrame& pose : poses) {
    if (snapshot.index_of(pose.submap) == 0) trajectory.push_back({pose.stamp, pose.T_wc});
  }
  return trajectory;
}

FrameCounts count_frames(const RunRecord& run, const Snapshot& snapshot) {
  FrameCounts counts;
  for (const FrameStats& f : run.frames.all()) {
    counts.late += f.state == FrameState::late;
    counts.unreadable += f.state == FrameState::unreadable;
    counts.camera_gone += f.state == FrameState::camera_gone;
  }
  counts.all = run.frames.size() - counts.camera_gone;
  counts.dropped = run.dropped;
  counts.tracked = snapshot.trajectory.size();
  counts.tracked_online = snapshot.online.size();
  if (!snapshot.online.empty()) counts.first_tracked = snapshot.online.front().frame;
  return counts;
}

MapCounts count_map(const RunRecord& run, const Snapshot& snapshot) {
  MapCounts counts;
  counts.key_frames_made = run.mapping.size();
  for (const MappingReport& m : run.mapping)
    counts.key_frames_thinned += static_cast<size_t>(m.counts.key_frames_thinned);
  counts.refused_non_finite = snapshot.refused_non_finite;
  counts.submaps = snapshot.submaps;
  for (const SubmapSummary& submap : snapshot.submaps) {
    counts.key_frames += submap.key_frames;
    counts.points += submap.points;
  }
  return counts;
}

FrameTimes times_of(const RunRecord& run) {
  auto done = run.frames.all() | std::views::filter(&FrameStats::processed);
  FrameTimes times;
  times.tracking = spread(done, [](const FrameStats& f) { return f.tracking_ms(); });
  times.frame = spread(done, [](const FrameStats& f) { return f.timing.total_ms; });
  times.cpu = spread(done, [](const FrameStats& f) { return f.cpu_ms; });
  for (const Stage& stage : kStages) times.stages.emplace_back(stage.name, spread(done, stage.ms));
  const auto mapping = [&](const char* name, auto ms) { times.mapping.emplace_back(name, spread(run.mapping, ms)); };
  mapping("insert", [](const MappingReport& m) { return m.ms.insert; });
  mapping("cull_points", [](const MappingReport& m) { return m.ms.cull_points; });
  mapping("create", [](const MappingReport& m) { return m.ms.create; });
  mapping("fuse", [](const MappingReport& m) { return m.ms.fuse; });
  mapping("align", [](const MappingReport& m) { return m.ms.align; });
  mapping("local_ba", [](const MappingReport& m) { return m.ms.adjust; });
  mapping("cull_key_frames", [](const MappingReport& m) { return m.ms.cull_key_frames; });
  mapping("loop", [](const MappingReport& m) { return m.loop_ms; });
  mapping("total", [](const MappingReport& m) { return m.total_ms; });
  return times;
}

void collect_loops(const std::vector<MappingReport>& mapping, RunSummary& summary) {
  for (size_t k = 0; k < mapping.size(); ++k) {
    const LoopReport& loop = mapping[k].loop;
    if (loop.outcome == LoopOutcome::joined) summary.merges.push_back({mapping[k].frame, loop});
    if (loop.outcome != LoopOutcome::closed) continue;
    // Its full bundle adjustment came some key frames later, unless another loop or the end was first.
    double full_ba_ms = 0;
    for (size_t later = k + 1; later < mapping.size() && !mapping[later].loop.changed_map(); ++later)
      full_ba_ms += mapping[later].full_adjustment_ms;
    summary.loops.push_back({mapping[k].frame, loop, full_ba_ms});
  }
}

std::vector<Loss> losses_of(const SpilledArray<FrameStats>& frames) {
  std::vector<Loss> losses;
  FrameState before = FrameState::tracking;
  for (const FrameStats& frame : frames.all()) {
    if (frame.state != FrameState::tracking) {
      if (frame.state != before) losses.push_back({frame.frame, frame.frame, frame.state, frame.reason});
      losses.back().last = frame.frame;
    }
    before = frame.state;
  }
  return losses;
}

std::optional<Accuracy> accuracy_of(const Snapshot& snapshot, const Trajectory& truth, AlignMode alignment) {
  const Trajectory trajectory = of_main_submap(snapshot.trajectory, snapshot);
  const auto final = evaluate(trajectory, truth, {.align = alignment}),
             online = evaluate(of_main_submap(snapshot.online, snapshot), truth, {.align = alignment});
  if (!final || !online) return std::nullopt;
  Accuracy accuracy{alignment, final->ate.rmse, online->ate.rmse, final->path_length, std::nullopt};
  if (const auto scaled = evaluate(trajectory, truth, {.align = AlignMode::sim3}))
    accuracy.scaled = {scaled->ate.rmse, scaled->scale};
  return accuracy;
}

}  // namespace

MainSubmap main_submap(const Snapshot& snapshot) {
  MainSubmap main{of_main_submap(snapshot.trajectory, snapshot),
                  of_main_submap(snapshot.online, snapshot),
                  of_main_submap(snapshot.key_frames, snapshot),
                  {}};
  for (const Snapshot::Point& point : snapshot.points) {
    if (snapshot.index_of(point.submap) == 0) main.points.push_back({point.position_w, point.colour});
  }
  return main;
}

const char* name_of_alignment(AlignMode mode) { return mode == AlignMode::sim3 ? "sim3" : "se3"; }

RunSummary summarise(const RunRecord& run, const Snapshot& snapshot, const Trajectory* truth, double peak_rss_mb) {
  RunSummary summary;
  summary.source = run.source;
  summary.sensor = run.sensor;
  summary.camera = snapshot.camera;
  summary.given = run.given;
  summary.image_height = run.image_height;
  summary.estimate = run.estimate;
  summary.interrupted = run.interrupted;
  summary.notes = run.notes;
  summary.failure = run.failure;
  summary.frames = count_frames(run, snapshot);
  summary.map = count_map(run, snapshot);
  summary.times = times_of(run);
  summary.costs = {run.wall_seconds, static_cast<double>(run.frames.size()) / std::max(run.wall_seconds, 1e-9),
                   run.first_pose_ms, peak_rss_mb};
  collect_loops(run.mapping, summary);
  summary.not_tracked = losses_of(run.frames);
  summary.warnings = run.warnings;
  if (truth) summary.accuracy = accuracy_of(snapshot, *truth, alignment_of(run.sensor));
  return summary;
}

}  // namespace covis::app
