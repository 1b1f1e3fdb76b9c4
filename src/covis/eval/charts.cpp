// SPDX-License-Identifier: Apache-2.0
#include "covis/eval/charts.h"

#include <cstdint>

namespace covis {
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

std::array<int, 2> widest_axes(const std::vector<Eigen::Vector3d>& path) {
  Eigen::Vector3d low = Eigen::Vector3d::Constant(1e300), high = -low;
  for (const Eigen::Vector3d& p : path) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  const Eigen::Vector3d spread = high - low;
  int least = 0;
  spread.minCoeff(&least);
  return {least == 0 ? 1 : 0, least == 2 ? 1 : 2};
}

Plot path_plot(const std::array<int, 2>& axes) {
  const char* names[] = {"x, m", "y, m", "z, m"};
  return {.title = "Path from above",
          .x_label = names[axes[0]],
          .y_label = names[axes[1]],
          .series = {},
          .equal_aspect = true,
          .width = 1000,
          .height = 760};
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

Plot error_plot(const Evaluation& evaluation) {
  PlotSeries error{"", {}, {}, kRed, PlotSeries::Style::line, 1.5};
  for (const ComparedPose& p : evaluation.compared) {
    error.x.push_back(to_seconds(p.stamp - evaluation.compared.front().stamp));
    error.y.push_back(p.error);
  }
  Plot plot{.title = "Distance to the truth after alignment", .x_label = "s", .y_label = "m", .series = {error}};
  plot.y_range = {0, 1.1 * evaluation.ate.max + 1e-9};
  return plot;
}

std::string html_escaped(const std::string& s) {
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

std::string html_image(const std::string& png, const std::string& what) {
  return "<img alt=\"" + html_escaped(what) + "\" src=\"data:image/png;base64," + base64(png) + "\">\n";
}

Result<std::string> html_plot(const Plot& plot, const std::string& what) {
  const auto png = draw({plot});
  if (!png) return tl::unexpected(png.error());
  return html_image(*png, what);
}

std::string html_page(const std::string& title, const std::string& body) {
  return "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" "
         "content=\"width=device-width\"><title>Covis: " +
         html_escaped(title) +
         "</title>\n<style>:root{color-scheme:light dark}body{font:15px/1.5 "
         "system-ui,sans-serif;max-width:1040px;margin:2em auto;padding:0 1em}"
         "img{max-width:100%;border-radius:6px;margin:.6em 0;background:#fff}table{border-collapse:collapse;margin:1em "
         "0}"
         "td,th{padding:.25em .9em .25em 0;text-align:left;border-bottom:1px solid "
         "#8884;vertical-align:top}td:nth-child(2){font-variant-numeric:tabular-nums}</style></head><body>\n<h1>" +
         html_escaped(title) + "</h1>\n" + body + "</body></html>\n";
}

}  // namespace covis
