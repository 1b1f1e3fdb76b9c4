// SPDX-License-Identifier: Apache-2.0
#include "covis/eval/report.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "covis/eval/plot.h"
#include "covis/io/files.h"

namespace covis {
namespace {

constexpr PlotColour kBlue{31, 105, 190}, kRed{205, 55, 45}, kGrey{175, 180, 188}, kGreen{30, 140, 80},
    kOrange{225, 140, 20}, kBlack{40, 40, 40};

std::string base64(const std::string& bytes) {
  static constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (size_t i = 0; i < bytes.size(); i += 3) {
    uint32_t v = 0;
    for (size_t k = 0; k < 3; ++k) v = v << 8 | (i + k < bytes.size() ? static_cast<uint8_t>(bytes[i + k]) : 0u);
    for (size_t k = 0; k < 4; ++k) text += i + k <= bytes.size() ? kDigits[v >> (18 - 6 * k) & 63] : '=';
  }
  return text;
}

std::string escaped(const std::string& s) {
  std::string text;
  for (const char c : s) {
    switch (c) {
      case '&':
        text += "&amp;";
        break;
      case '<':
        text += "&lt;";
        break;
      case '>':
        text += "&gt;";
        break;
      case '"':
        text += "&quot;";
        break;
      default:
        text += c;
    }
  }
  return text;
}

// The two axes along which the path spreads most: what "from above" is when nobody says where down is.
std::array<int, 2> widest_axes(const Trajectory& path) {
  Eigen::Vector3d low = Eigen::Vector3d::Constant(1e300), high = -low;
  for (const StampedPose& p : path) {
    low = low.cwiseMin(p.T_wc.t());
    high = high.cwiseMax(p.T_wc.t());
  }
  const Eigen::Vector3d spread = high - low;
  int least = 0;
  spread.minCoeff(&least);
  return {least == 0 ? 1 : 0, least == 2 ? 1 : 2};
}

PlotSeries path_series(const std::string& label, const std::vector<Eigen::Vector3d>& points,
                       const std::array<int, 2>& axes, PlotColour colour) {
  PlotSeries s{label, {}, {}, colour, PlotSeries::Style::line, 2};
  for (const Eigen::Vector3d& p : points) {
    s.x.push_back(p(axes[0]));
    s.y.push_back(p(axes[1]));
  }
  return s;
}

std::string path_picture(const ReportInput& in, const Result<Evaluation>& evaluation) {
  const auto axes = widest_axes(in.estimate);
  const char* names[] = {"x, m", "y, m", "z, m"};
  Plot plot{.title = "Path from above",
            .x_label = names[axes[0]],
            .y_label = names[axes[1]],
            .series = {},
            .equal_aspect = true,
            .width = 1000,
            .height = 760};
  std::vector<Eigen::Vector3d> path, frames;
  for (const StampedPose& p : in.estimate) path.push_back(p.T_wc.t());
  for (const StampedPose& p : in.key_frames) frames.push_back(p.T_wc.t());
  PlotSeries points = path_series("map points", in.points, axes, kGrey);
  points.style = PlotSeries::Style::dots;
  points.width = 0.8;
  plot.series.push_back(std::move(points));
  if (evaluation) {
    // The truth in the estimate's world: the inverse of the alignment, found by aligning the other way.
    std::vector<Eigen::Vector3d> estimated, truth;
    for (const ComparedPose& p : evaluation->compared) truth.push_back(p.truth.t());
    size_t next = 0;
    for (const StampedPose& p : in.estimate) {
      if (next < evaluation->compared.size() && evaluation->compared[next].stamp == p.stamp) {
        estimated.push_back(p.T_wc.t());
        ++next;
      }
    }
    if (const auto back = align(truth, estimated, in.align == AlignMode::sim3)) {
      for (Eigen::Vector3d& p : truth) p = *back * p;
      plot.series.push_back(path_series("truth", truth, axes, kRed));
    }
  }
  plot.series.push_back(path_series("path", path, axes, kBlue));
  PlotSeries marks = path_series("key frames", frames, axes, kBlack);
  marks.style = PlotSeries::Style::marks;
  marks.width = 3;
  plot.series.push_back(std::move(marks));
  // Room round the path for the map's points, though not for all of them.
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
  return draw(plot);
}

double quantile(std::vector<double> v, double q) {
  std::sort(v.begin(), v.end());
  return v.empty() ? 0 : v[static_cast<size_t>(q * static_cast<double>(v.size() - 1) + 0.5)];
}

std::string time_picture(const ReportInput& in) {
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
  return draw(plot);
}

std::string coverage_picture(const ReportInput& in) {
  PlotSeries inliers{"inliers", {}, {}, kBlue, PlotSeries::Style::line, 1},
      missing{"not tracked", {}, {}, kRed, PlotSeries::Style::dots, 2.5};
  for (const ReportFrame& f : in.frames) {
    const bool tracked = f.state == "tracking";
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
  return draw(plot);
}

std::string error_picture(const Evaluation& evaluation) {
  PlotSeries error{"", {}, {}, kRed, PlotSeries::Style::line, 1.5};
  for (const ComparedPose& p : evaluation.compared) {
    error.x.push_back(to_seconds(p.stamp - evaluation.compared.front().stamp));
    error.y.push_back(p.error);
  }
  Plot plot{.title = "Distance to the truth after alignment", .x_label = "s", .y_label = "m", .series = {error}};
  plot.y_range = {0, 1.1 * evaluation.ate.max + 1e-9};
  return draw(plot);
}

// Stretches without a pose, with the reason of their first frame.
std::string gaps_table(const ReportInput& in) {
  std::string rows;
  for (size_t i = 0; i < in.frames.size();) {
    if (in.frames[i].state == "tracking") {
      ++i;
      continue;
    }
    size_t end = i;
    while (end + 1 < in.frames.size() && in.frames[end + 1].state == in.frames[i].state) ++end;
    rows += "<tr><td>" + std::to_string(in.frames[i].index) + " – " + std::to_string(in.frames[end].index) +
            "</td><td>" + escaped(in.frames[i].state) + "</td><td>" + escaped(in.frames[i].reason) + "</td></tr>\n";
    i = end + 1;
  }
  return rows.empty() ? "<p>Every frame was tracked.</p>\n"
                      : "<table><tr><th>frames</th><th>state</th><th>reason</th></tr>\n" + rows + "</table>\n";
}

}  // namespace

Result<void> write_report(const std::filesystem::path& folder, const ReportInput& in) {
  const Result<Evaluation> evaluation =
      in.truth ? evaluate(in.estimate, *in.truth, {.align = in.align}) : Result<Evaluation>(fail("no truth"));
  const auto image = [](const std::string& png, const char* what) {
    return "<img alt=\"" + std::string(what) + "\" src=\"data:image/png;base64," + base64(png) + "\">\n";
  };
  std::string html =
      "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" "
      "content=\"width=device-width\"><title>Covis: " +
      escaped(in.title) +
      "</title>\n<style>:root{color-scheme:light dark}body{font:15px/1.5 "
      "system-ui,sans-serif;max-width:1040px;margin:2em auto;padding:0 1em}"
      "img{max-width:100%;border-radius:6px;margin:.6em 0;background:#fff}table{border-collapse:collapse;margin:1em 0}"
      "td,th{padding:.25em .9em .25em 0;text-align:left;border-bottom:1px solid "
      "#8884;vertical-align:top}td:nth-child(2){font-variant-numeric:tabular-nums}</style></head><body>\n<h1>" +
      escaped(in.title) + "</h1>\n<table>\n";
  for (const auto& [name, value] : in.summary)
    html += "<tr><td>" + escaped(name) + "</td><td>" + escaped(value) + "</td></tr>\n";
  html += "</table>\n";
  Result<void> problem;
  if (!in.estimate.empty()) {
    const std::string path = path_picture(in, evaluation);
    html += image(path, "path from above");
    problem = io::write_text_atomically(folder / "trajectory.png", path);
  }
  if (evaluation) html += image(error_picture(*evaluation), "error over time");
  html += image(coverage_picture(in), "inliers per frame") + image(time_picture(in), "time per frame");
  html += "<h2>Frames without a pose</h2>\n" + gaps_table(in) + "</body></html>\n";
  if (auto written = io::write_text_atomically(folder / "report.html", html); !written) return written;
  return problem;
}

}  // namespace covis
