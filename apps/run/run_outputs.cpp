// SPDX-License-Identifier: Apache-2.0
#include "apps/run/run_outputs.h"

#include <algorithm>
#include <iterator>
#include <nlohmann/json.hpp>
#include <system_error>
#include <utility>

#include "apps/run/run_json.h"
#include "apps/run/run_text.h"
#include "apps/run/run_view.h"
#include "apps/view/page.h"
#include "covis/core/atomic_file.h"
#include "covis/core/log.h"
#include "covis/core/sensor.h"
#include "covis/eval/report.h"
#include "covis/io/files.h"
#include "covis/io/output_check.h"

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

// Names and kinds of the files of each run.
constexpr std::pair<const char*, io::OutputKind> kFiles[] = {
    {"trajectory.txt", io::OutputKind::trajectory}, {"trajectory_online.txt", io::OutputKind::trajectory},
    {"keyframes.txt", io::OutputKind::trajectory},  {"map.ply", io::OutputKind::point_cloud},
    {"stats.jsonl", io::OutputKind::json},          {"summary.json", io::OutputKind::json},
    {"scene.bin", io::OutputKind::scene},           {"report.html", io::OutputKind::page},
    {"trajectory.png", io::OutputKind::png},        {"trajectory_online_times.txt", io::OutputKind::times},
    {"keyframes_times.txt", io::OutputKind::times}};

bool has_results(const std::filesystem::path& folder) {
  return std::any_of(std::begin(kFiles), std::end(kFiles), [&](const auto& file) {
    std::error_code none;
    return std::filesystem::exists(folder / file.first, none);
  });
}

}  // namespace

Result<void> open_output_folder(const std::filesystem::path& folder, const std::vector<std::filesystem::path>& given) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) return fail(folder.string() + ": the output folder can't be made: " + error.message());
  for (const auto& [name, kind] : kFiles) {
    if (auto fits = io::check_output(folder / name, kind, given); !fits) return fits;
  }
  // Files of stamps are checked whether this run writes some or not, as those of an earlier run go.
  const auto fits = io::check_trajectories(folder / "trajectory.txt", given, io::TrajectoryFormat::kitti);
  if (!fits) return fits;
  // Permissions alone do not tell of a read-only disk or a sandbox.
  if (const auto writable = check_writable(folder / "trajectory.txt"); !writable)
    return fail("the output folder can't be written to: " + writable.error().message);
  return {};
}

std::optional<std::string> why_nothing_is_written(const RunRecord& run, const Snapshot& snapshot,
                                                  const std::filesystem::path& folder) {
  if (run.interrupted || !run.failure.empty()) {
    if (!snapshot.trajectory.empty() || !has_results(folder)) return std::nullopt;
    return (run.failure.empty() ? "interrupted" : run.failure) +
           "; no frame was tracked, so that the older results in " + folder.string() + " stay";
  }
  std::string first;
  for (size_t k = 0; k < run.frames.size(); ++k) {
    const FrameStats frame = run.frames[k];
    if (frame.state != FrameState::unreadable) return std::nullopt;
    if (first.empty()) first = "; of the first: " + frame.reason;
  }
  return "no frame could be read" + first;
}

std::optional<Trajectory> read_truth(const io::Sequence& sequence) {
  if (!sequence.truth()) return std::nullopt;
  auto truth = io::load_truth(sequence);
  if (truth) return std::move(*truth);
  log(LogLevel::warning, truth.error().message);
  return std::nullopt;
}

Result<void> write_outputs(const RunRecord& run, const Snapshot& snapshot, const RunSummary& summary,
                           const OutputOptions& options) {
  using nlohmann::json;
  MainSubmap results = main_submap(snapshot);
  const std::filesystem::path& out = options.directory;
  Result<void> problem;
  // A lack of memory for one, as for the report's pictures, must not cost the others.
  const auto keep_first = [&](const char* name, const auto& write) {
    auto written = io::without_exceptions(out / name, [&] { return write(out / name); });
    if (!written && problem) problem = std::move(written);
  };
  using File = std::filesystem::path;
  const auto keep_trajectory = [&](const char* name, const Trajectory& trajectory) {
    keep_first(name, [&](const File& file) { return io::write_with_times(file, trajectory, options.format); });
  };
  keep_first("trajectory.txt",
             [&](const File& file) { return io::write_trajectories(file, by_submap(snapshot), options.format); });
  keep_trajectory("trajectory_online.txt", results.online_trajectory);
  keep_trajectory("keyframes.txt", results.key_frames);
  keep_first("map.ply", [&](const File& file) { return io::write_ply(file, results.points, options.unit); });
  keep_first("stats.jsonl", [&](const File& file) {
    return write_atomically(file, [&](FileSink& sink) {
      append_stats(run, snapshot, sink);
      return Result<void>();
    });
  });
  keep_first("summary.json", [&](const File& file) {
    return write_atomically(file, to_json(summary).dump(2, ' ', false, json::error_handler_t::replace) + "\n");
  });
  view::ViewState seen;
  keep_first("scene.bin", [&](const File& file) {
    seen = view_state(run, snapshot, summary, options.title);
    return write_atomically(file, view::file_of(seen));
  });
  keep_first("report.html", [&](const File&) {
    ReportInput report = report_of(run, std::move(results), summary, options);
    report.viewer = view::embedded_page(seen);
    return write_report(out, report);
  });
  return problem;
}

}  // namespace covis::app
