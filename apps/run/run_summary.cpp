// SPDX-License-Identifier: Apache-2.0
#include "apps/run/run_summary.h"

#include <algorithm>

#include "covis/core/quantile.h"

namespace covis::app {
namespace {

Spread spread_of(const std::vector<double>& values) { return {quantile(values, 0.5), quantile(values, 0.95)}; }

template <class Item, class Value>
Spread spread(const std::vector<Item>& items, Value value) {
  std::vector<double> values;
  for (const Item& item : items) values.push_back(value(item));
  return spread_of(values);
}

Trajectory of_main_map(const std::vector<PoseOfFrame>& poses) {
  Trajectory trajectory;
  for (const PoseOfFrame& pose : poses) {
    if (pose.submap_index == 0) trajectory.push_back({pose.stamp, pose.T_wc});
  }
  return trajectory;
}

FrameCounts count_frames(const RunRecord& run, const std::vector<FrameRecord>& records) {
  FrameCounts counts;
  counts.all = run.frames.size();
  for (const FrameStats& f : run.frames) {
    counts.late += f.state == FrameState::late;
    counts.unreadable += f.state == FrameState::unreadable;
  }
  for (const FrameRecord& r : records) {
    counts.tracked += r.tracked;
    counts.tracked_online += r.online;
    if (r.online && counts.first_tracked < 0) counts.first_tracked = r.frame;
  }
  return counts;
}

MapCounts count_map(const RunRecord& run, const RunResults& results) {
  MapCounts counts;
  counts.key_frames_made = run.mapping.size();
  counts.refused_non_finite = results.refused_non_finite;
  counts.submaps = results.submaps;
  for (const SubmapSummary& map : results.submaps) {
    counts.key_frames += map.key_frames;
    counts.points += map.points;
  }
  return counts;
}

FrameTimes times_of(const RunRecord& run) {
  std::vector<FrameStats> done;
  std::copy_if(run.frames.begin(), run.frames.end(), std::back_inserter(done),
               [](const FrameStats& f) { return f.processed(); });
  FrameTimes times;
  times.tracking = spread(done, [](const FrameStats& f) { return f.tracking_ms(); });
  times.frame = spread(done, [](const FrameStats& f) { return f.timing.total_ms; });
  times.cpu = spread(done, [](const FrameStats& f) { return f.cpu_ms; });
  for (const Stage& stage : kStages) times.stages.emplace_back(stage.name, spread(done, stage.ms));
  const auto mapping = [&](const char* name, double MappingReport::*ms) {
    times.mapping.emplace_back(name, spread(run.mapping, [&](const MappingReport& m) { return m.*ms; }));
  };
  mapping("insert", &MappingReport::insert_ms);
  mapping("cull_points", &MappingReport::cull_points_ms);
  mapping("create", &MappingReport::create_ms);
  mapping("fuse", &MappingReport::fuse_ms);
  mapping("local_ba", &MappingReport::ba_ms);
  mapping("cull_key_frames", &MappingReport::cull_key_frames_ms);
  mapping("loop", &MappingReport::loop_ms);
  mapping("total", &MappingReport::total_ms);
  return times;
}

void collect_loops(const std::vector<MappingReport>& mapping, RunSummary& summary) {
  for (size_t k = 0; k < mapping.size(); ++k) {
    const LoopReport& loop = mapping[k].loop;
    if (loop.merged) summary.merges.push_back({mapping[k].frame, loop});
    if (!loop.loop.valid() || loop.merged) continue;
    // The full bundle adjustment of a loop is reported some key frames later, unless another loop or the end precedes
    // it.
    double full_ba_ms = 0;
    for (size_t later = k + 1; later < mapping.size() && !mapping[later].loop.loop.valid(); ++later)
      full_ba_ms += mapping[later].loop.full_ba_ms;
    summary.loops.push_back({mapping[k].frame, loop, full_ba_ms});
  }
}

std::vector<Loss> losses_of(const std::vector<FrameStats>& frames) {
  std::vector<Loss> losses;
  FrameState before = FrameState::tracking;
  for (const FrameStats& frame : frames) {
    if (frame.state != FrameState::tracking) {
      if (frame.state != before) losses.push_back({frame.frame, frame.frame, frame.state, frame.reason});
      losses.back().last = frame.frame;
    }
    before = frame.state;
  }
  return losses;
}

std::optional<Accuracy> accuracy_of(const RunResults& results, const Trajectory& truth, AlignMode alignment) {
  const auto final = evaluate(results.trajectory, truth, {.align = alignment}),
             online = evaluate(results.online_trajectory, truth, {.align = alignment});
  if (!final || !online) return std::nullopt;
  Accuracy accuracy{alignment, final->ate.rmse, online->ate.rmse, final->path_length, std::nullopt};
  if (const auto scaled = evaluate(results.trajectory, truth, {.align = AlignMode::sim3}))
    accuracy.scaled = {scaled->ate.rmse, scaled->scale};
  return accuracy;
}

}  // namespace

RunResults results_of(const System& system) {
  RunResults results;
  results.camera = system.camera();
  results.submaps = system.submaps();
  results.records = system.records();
  results.poses = system.trajectory();
  results.trajectory = of_main_map(results.poses);
  results.online_trajectory = of_main_map(system.online_trajectory());
  results.key_frames = of_main_map(system.key_frames());
  const auto map = system.map().read();
  results.refused_non_finite = map->refused_non_finite();
  map->for_each_point([&](MapPointId, const MapPoint& point) {
    if (map->at(point.reference).submap == results.submaps.front().id) results.points.push_back(point.position_w);
  });
  return results;
}

const char* name_of_alignment(AlignMode mode) { return mode == AlignMode::sim3 ? "sim3" : "se3"; }

RunSummary summarise(const RunRecord& run, const RunResults& results, const Trajectory* truth, double peak_rss_mb) {
  RunSummary summary;
  summary.source = run.source;
  summary.sensor = run.sensor;
  summary.camera = results.camera;
  summary.interrupted = run.interrupted;
  summary.frames = count_frames(run, results.records);
  summary.map = count_map(run, results);
  summary.times = times_of(run);
  summary.costs = {run.wall_seconds, static_cast<double>(run.frames.size()) / std::max(run.wall_seconds, 1e-9),
                   run.first_pose_ms, peak_rss_mb};
  collect_loops(run.mapping, summary);
  summary.not_tracked = losses_of(run.frames);
  if (truth) summary.accuracy = accuracy_of(results, *truth, alignment_of(run.sensor));
  return summary;
}

}  // namespace covis::app
