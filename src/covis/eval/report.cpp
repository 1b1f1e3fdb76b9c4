// SPDX-License-Identifier: Apache-2.0
#include "covis/eval/report.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "covis/core/atomic_file.h"
#include "covis/core/quantile.h"
#include "covis/eval/charts.h"

namespace covis {
namespace {

Plot path_from_above(const ReportInput& in, const Result<Evaluation>& evaluation) {
  std::vector<Eigen::Vector3d> path, frames;
  for (const StampedPose& p : in.estimate) path.push_back(p.T_wc.t());
  for (const StampedPose& p : in.key_frames) frames.push_back(p.T_wc.t());
  const auto axes = widest_axes(path);
  Plot plot = path_plot(axes);
  PlotSeries points = path_series("map points", in.points, axes, kGrey);
  points.style = PlotSeries::Style::dots;
  points.width = 0.8;
  plot.series.push_back(std::move(points));
  if (evaluation) {
    // The ground truth is moved into the world of the estimate by aligning in the opposite direction.
    std::vector<Eigen::Vector3d> estimated, truth;
    for (const ComparedPose& p : evaluation->compared) truth.push_back(p.truth.t());
    size_t next = 0;
    for (const StampedPose& p : in.estimate) {
      if (next < evaluation->compared.size() && evaluation->compared[next].stamp == p.stamp) {
        estimated.push_back(p.T_wc.t());
        ++next;
      }
    }
    if (const auto back = align(truth, estimated, in.align == AlignMode::sim3 ? Scale::free : Scale::fixed)) {
      for (Eigen::Vector3d& p : truth) p = *back * p;
      plot.series.push_back(path_series("truth", truth, axes, kRed));
    }
  }
  plot.series.push_back(path_series("path", path, axes, kBlue));
  PlotSeries marks = path_series("key frames", frames, axes, kBlack);
  marks.style = PlotSeries::Style::marks;
  marks.width = 3;
  plot.series.push_back(std::move(marks));
  // Enlarge the range around the path for the map's points, but not for all of them.
  for (const bool first : {true, false}) {
    double low = 1e300, high = -1e300;
    for (const Eigen::Vector3d& p : path) {
      low = std::min(low, p(axes[first ? 0 : 1]));
      high = std::max(high, p(axes[first ? 0 : 1]));
    }
    (first ? plot.x_range : plot.y_range) = {low, high};
  }
  const double room = 0.35 * std::max(plot.x_range[1] - plot.x_range[0], plot.y_range[1] - plot.y_range[0]) + 1e-6;
  for (auto* range : {&plot.x_range, &plot.y_range}) *range = {(*range)[0] - room, (*range)[1] + room};
  return plot;
}

Plot time_plot(const ReportInput& in) {
  PlotSeries time{"tracking", {}, {}, kBlue, PlotSeries::Style::line, 1},
      marks{"key frame", {}, {}, kBlack, PlotSeries::Style::marks, 2.5};
  std::vector<double> values;
  for (const ReportFrame& f : in.frames) {
    if (f.tracking_ms <= 0) continue;
    time.x.push_back(static_cast<double>(f.index));
    time.y.push_back(f.tracking_ms);
    values.push_back(f.tracking_ms);
    if (f.key_frame) {
      marks.x.push_back(static_cast<double>(f.index));
      marks.y.push_back(f.tracking_ms);
    }
  }
  Plot plot{.title = "Time per frame", .x_label = "frame", .y_label = "ms", .series = {time, marks}};
  if (!time.x.empty()) {
    for (const auto& [label, q, colour] : {std::tuple{"median", 0.5, kGreen}, std::tuple{"95 %", 0.95, kOrange}}) {
      plot.series.push_back({label,
                             {time.x.front(), time.x.back()},
                             {quantile(values, q), quantile(values, q)},
                             colour,
                             PlotSeries::Style::line,
                             2});
    }
  }
  plot.y_range = {0, std::max(1e-3, 1.6 * quantile(values, 0.98))};
  return plot;
}

Plot coverage_plot(const ReportInput& in) {
  PlotSeries inliers{"inliers", {}, {}, kBlue, PlotSeries::Style::line, 1},
      missing{"not tracked", {}, {}, kRed, PlotSeries::Style::dots, 2.5};
  for (const ReportFrame& f : in.frames) {
    const bool tracked = f.loss.empty();
    inliers.x.push_back(static_cast<double>(f.index));
    inliers.y.push_back(tracked ? f.inliers : std::numeric_limits<double>::quiet_NaN());
    if (tracked) continue;
    missing.x.push_back(static_cast<double>(f.index));
    missing.y.push_back(0);
  }
  Plot plot{.title = "Coverage: map points that agree with the pose",
            .x_label = "frame",
            .y_label = "points",
            .series = {inliers, missing}};
  double high = 10;
  for (const double v : inliers.y) high = std::isfinite(v) ? std::max(high, v) : high;
  plot.y_range = {-0.05 * high, 1.05 * high};
  return plot;
}

// Intervals without a pose, with the reason of their first frame.
std::string gaps_table(const ReportInput& in) {
  std::string rows;
  for (size_t i = 0; i < in.frames.size();) {
    if (in.frames[i].loss.empty()) {
      ++i;
      continue;
    }
    size_t end = i;
    while (end + 1 < in.frames.size() && in.frames[end + 1].loss == in.frames[i].loss) ++end;
    rows += "<tr><td>" + std::to_string(in.frames[i].index) + " – " + std::to_string(in.frames[end].index) +
            "</td><td>" + html_escaped(in.frames[i].loss) + "</td><td>" + html_escaped(in.frames[i].reason) +
            "</td></tr>\n";
    i = end + 1;
  }
  return rows.empty() ? "<p>Every frame was tracked.</p>\n"
                      : "<table><tr><th>frames</th><th>state</th><th>reason</th></tr>\n" + rows + "</table>\n";
}

}  // namespace

Result<void> write_report(const std::filesystem::path& folder, const ReportInput& in) {
  const Result<Evaluation> evaluation =
      in.truth ? evaluate(in.estimate, *in.truth, {.align = in.align}) : Result<Evaluation>(fail("no truth"));
  std::string html = "<table>\n";
  for (const auto& [name, value] : in.summary)
    html += "<tr><td>" + html_escaped(name) + "</td><td>" + html_escaped(value) + "</td></tr>\n";
  html += "</table>\n";
  html += in.viewer;
  Result<void> problem;
  const auto add = [&](const Plot& plot, const std::string& what) {
    auto image = html_plot(plot, what);
    if (image) {
      html += *image;
    } else {
      problem = tl::unexpected(std::move(image.error()));  // the page is written without it
    }
  };
  if (!in.estimate.empty()) {
    const Plot path = path_from_above(in, evaluation);
    add(path, "path from above");
    if (problem) problem = write_plots(folder / "trajectory.png", {path});
  }
  if (evaluation) add(error_plot(*evaluation), "error over time");
  if (in.viewer.empty()) {
    add(coverage_plot(in), "inliers per frame");
    add(time_plot(in), "time per frame");
  }
  html += "<h2>Frames without a pose</h2>\n" + gaps_table(in);
  if (auto written = write_atomically(folder / "report.html", html_page(in.title, html)); !written) return written;
  return problem;
}

Result<void> write_picture(const std::filesystem::path& file, const std::string& title, const Evaluation& evaluation) {
  std::vector<Eigen::Vector3d> estimate, truth;
  for (const ComparedPose& p : evaluation.compared) {
    estimate.push_back(p.estimate.t());
    truth.push_back(p.truth.t());
  }
  const auto axes = widest_axes(truth);
  Plot path = path_plot(axes);
  path.series = {path_series("truth", truth, axes, kRed), path_series("path", estimate, axes, kBlue)};
  if (file.extension() == ".png") return write_plots(file, {path, error_plot(evaluation)});
  if (file.extension() != ".html") return fail(file.string() + ": the picture's name must end in .png or .html");
  const auto above = html_plot(path, "path from above");
  const auto errors = html_plot(error_plot(evaluation), "error over time");
  if (!above || !errors) return tl::unexpected((above ? errors : above).error());
  return write_atomically(
      file, html_page(title, "<pre>" + html_escaped(to_text(evaluation)) + "</pre>\n" + *above + *errors));
}

}  // namespace covis
