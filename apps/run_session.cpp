// SPDX-License-Identifier: Apache-2.0
#include "run_session.h"

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "common.h"
#include "covis/eval/evaluation.h"
#include "covis/eval/report.h"
#include "covis/io/files.h"
#include "covis/io/outputs.h"

namespace covis::app {
namespace {

using nlohmann::json;

// One for each map; an empty one when there is no map at all.
template <class Poses>
std::vector<Trajectory> by_map(const Poses& poses, const Snapshot& snapshot) {
  std::vector<Trajectory> trajectories(std::max<size_t>(1, snapshot.submaps.size()));
  for (const PoseOfFrame& pose : poses) {
    // A pose as it was when tracked may be in a submap that has been joined to another since.
    if (const auto index = snapshot.index_of(pose.submap)) trajectories[*index].push_back({pose.stamp, pose.T_wc});
  }
  return trajectories;
}

AlignMode alignment_of(Sensor sensor) { return sensor == Sensor::monocular ? AlignMode::sim3 : AlignMode::se3; }

// Adds the errors of the final and the online trajectory where there is truth.
void add_errors(const OutputOptions& options, Sensor sensor, const Trajectory& final, const Trajectory& online,
                json& summary) {
  if (!options.truth) return;
  const EvaluationOptions evaluation{.align = alignment_of(sensor)};
  const auto of_final = evaluate(final, *options.truth, evaluation),
             of_online = evaluate(online, *options.truth, evaluation);
  if (!of_final || !of_online) return;
  summary["ate_m"] = of_final->ate.rmse;
  summary["ate_online_m"] = of_online->ate.rmse;
  summary["ate_alignment"] = sensor == Sensor::monocular ? "sim3" : "se3";
  summary["truth_path_m"] = of_final->path_length;
  if (const auto scaled = evaluate(final, *options.truth, {.align = AlignMode::sim3})) {
    summary["ate_sim3_m"] = scaled->ate.rmse;
    summary["scale"] = scaled->scale;
  }
}

std::string fixed(double value, int digits, const char* unit) {
  char text[64];
  std::snprintf(text, sizeof text, "%.*f%s", digits, value, unit);
  return text;
}

// The summary's main figures in words.
std::vector<std::pair<std::string, std::string>> rows_of(const json& s) {
  std::vector<std::pair<std::string, std::string>> rows{
      {"recording", s["source"].get<std::string>()},
      {"frames tracked",
       std::to_string(s["frames_tracked"].get<int64_t>()) + " of " + std::to_string(s["frames"].get<int64_t>())},
      {"key frames", std::to_string(s["keyframes"].get<int64_t>())},
      {"map points", std::to_string(s["map_points"].get<int64_t>())},
      {"tracking, median (95 %)", fixed(s["tracking_ms"]["median"].get<double>(), 2, " ms") + " (" +
                                      fixed(s["tracking_ms"]["p95"].get<double>(), 2, " ms)")},
      {"frames a second", fixed(s["frames_per_second"].get<double>(), 1, "")},
      {"peak memory", fixed(s["peak_rss_mb"].get<double>(), 0, " MB")}};
  if (s["maps"].size() > 1) rows.emplace_back("maps, not joined", std::to_string(s["maps"].size()));
  if (s.contains("ate_m")) {
    rows.emplace_back("error (ATE RMSE, " + s["ate_alignment"].get<std::string>() + ")",
                      fixed(s["ate_m"].get<double>(), 4, " m"));
    rows.emplace_back("as it was when tracked", fixed(s["ate_online_m"].get<double>(), 4, " m"));
    rows.emplace_back("length of the path", fixed(s["truth_path_m"].get<double>(), 2, " m"));
  }
  return rows;
}

std::vector<ReportFrame> report_frames(const RunRecord& run) {
  std::vector<ReportFrame> frames;
  for (const FrameStats& f : run.frames) {
    frames.push_back(
        {f.frame, f.state, f.reason, processed(f) ? f.tracking_ms() : 0, f.track.inliers, f.track.key_frame});
  }
  return frames;
}

}  // namespace

Result<json> write_outputs(const RunRecord& run, const Snapshot& snapshot, const OutputOptions& options) {
  const std::vector<Trajectory> trajectories = by_map(snapshot.trajectory, snapshot);
  const Trajectory& final = trajectories.front();
  const Trajectory online = by_map(snapshot.online, snapshot).front();
  const Trajectory key_frames = by_map(snapshot.key_frames, snapshot).front();
  std::vector<Eigen::Vector3d> points;
  for (const Snapshot::Point& point : snapshot.points) {
    if (snapshot.index_of(point.submap) == 0) points.push_back(point.position_w);
  }
  json summary = summarise(run, snapshot);
  add_errors(options, run.sensor, final, online, summary);
  const std::filesystem::path& out = options.directory;
  Result<void> problem;
  const auto keep_first = [&](Result<void> written) {
    if (!written && problem) problem = std::move(written);
  };
  keep_first(write_trajectories(out / "trajectory.txt", trajectories, options.format));
  keep_first(io::write_trajectory(out / "trajectory_online.txt", online, options.format));
  keep_first(io::write_trajectory(out / "keyframes.txt", key_frames, options.format));
  keep_first(io::write_ply(out / "map.ply", points));
  keep_first(io::write_text_atomically(out / "stats.jsonl", stats_text(run, snapshot)));
  keep_first(io::write_text_atomically(out / "summary.json",
                                       summary.dump(2, ' ', false, json::error_handler_t::replace) + "\n"));
  ReportInput report;
  report.title = options.title;
  report.estimate = final;
  report.key_frames = key_frames;
  report.truth = options.truth;
  report.align = alignment_of(run.sensor);
  report.points = std::move(points);
  report.frames = report_frames(run);
  report.summary = rows_of(summary);
  keep_first(write_report(out, report));
  if (!problem) return tl::unexpected(problem.error());
  return summary;
}

}  // namespace covis::app
