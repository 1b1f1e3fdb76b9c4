// SPDX-License-Identifier: Apache-2.0
#include "apps/run/run_outputs.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "apps/run/run_json.h"
#include "apps/run/run_text.h"
#include "apps/run/run_view.h"
#include "apps/view/page.h"
#include "covis/core/atomic_file.h"
#include "covis/eval/report.h"
#include "covis/io/outputs.h"

namespace covis::app {
namespace {

// One trajectory for each submap; an empty one when there is no map at all.
std::vector<Trajectory> by_submap(const Snapshot& snapshot) {
  std::vector<Trajectory> trajectories(std::max<size_t>(1, snapshot.submaps.size()));
  for (const PoseOfFrame& pose : snapshot.trajectory) {
    if (const auto index = snapshot.index_of(pose.submap)) trajectories[*index].push_back({pose.stamp, pose.T_wc});
  }
  return trajectories;
}

std::vector<ReportFrame> report_frames(const RunRecord& run) {
  std::vector<ReportFrame> frames;
  for (const FrameStats& f : run.frames.all()) {
    frames.push_back({f.frame, std::string(f.state == FrameState::tracking ? "" : name(f.state)), f.reason,
                      f.processed() ? f.tracking_ms() : 0, f.track.inliers, f.track.key_frame});
  }
  return frames;
}

ReportInput report_of(const RunRecord& run, MainSubmap results, const RunSummary& summary,
                      const OutputOptions& options) {
  ReportInput report;
  report.title = options.title;
  report.estimate = std::move(results.trajectory);
  report.key_frames = std::move(results.key_frames);
  report.truth = options.truth;
  report.align = alignment_of(run.sensor);
  for (const io::CloudPoint& point : results.points) report.points.push_back(point.position);
  report.frames = report_frames(run);
  report.summary = summary_rows(summary);
  return report;
}

}  // namespace

Result<void> write_outputs(const RunRecord& run, const Snapshot& snapshot, const RunSummary& summary,
                           const OutputOptions& options) {
  using nlohmann::json;
  MainSubmap results = main_submap(snapshot);
  const std::filesystem::path& out = options.directory;
  Result<void> problem;
  const auto keep_first = [&](Result<void> written) {
    if (!written && problem) problem = std::move(written);
  };
  keep_first(io::write_trajectories(out / "trajectory.txt", by_submap(snapshot), options.format));
  keep_first(io::write_trajectory(out / "trajectory_online.txt", results.online_trajectory, options.format));
  keep_first(io::write_trajectory(out / "keyframes.txt", results.key_frames, options.format));
  keep_first(io::write_ply(out / "map.ply", results.points));
  keep_first(write_atomically(out / "stats.jsonl", [&](FileSink& sink) {
    append_stats(run, snapshot, sink);
    return Result<void>();
  }));
  keep_first(write_atomically(out / "summary.json",
                              to_json(summary).dump(2, ' ', false, json::error_handler_t::replace) + "\n"));
  const view::ViewState seen = view_state(run, snapshot, summary, options.title);
  keep_first(write_atomically(out / "scene.bin", view::file_of(seen)));
  ReportInput report = report_of(run, std::move(results), summary, options);
  report.viewer = view::embedded_page(seen);
  keep_first(write_report(out, report));
  return problem;
}

}  // namespace covis::app
