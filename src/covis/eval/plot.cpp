// SPDX-License-Identifier: Apache-2.0
#include "covis/eval/plot.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "covis/core/atomic_file.h"
#include "covis/io/codecs.h"
#include "covis/io/output_check.h"

namespace covis {
namespace {

constexpr int kLeft = 78, kRight = 20, kTop = 38, kBottom = 52;  // margins, pixels
constexpr int kShift = 4;                                        // fractional bits of drawn coordinates
const cv::Scalar kInk(60, 60, 60), kGrid(230, 230, 230), kFrame(160, 160, 160);

cv::Scalar bgr(const PlotColour& c) {
  return {static_cast<double>(c.b), static_cast<double>(c.g), static_cast<double>(c.r)};
}

// Returns a step of 1, 2 or 5 times a power of ten that gives about `count` ticks.
double tick_step(double span, int count) {
  const double raw = span / count, power = std::pow(10, std::floor(std::log10(raw)));
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (factor * power >= raw) return factor * power;
  }
  return 10 * power;
}

std::string tick_text(double value, double step) {
  char text[32];
  const int digits = std::max(0, -static_cast<int>(std::floor(std::log10(step) + 1e-9)));
  std::snprintf(text, sizeof text, "%.*f", digits, std::abs(value) < step * 1e-6 ? 0.0 : value);
  return text;
}

struct Canvas {
  cv::Mat image;
  double x0, x1, y0, y1;  // range of the data that is drawn
  cv::Rect2d box;         // area of the axes, pixels

  cv::Point at(double x, double y) const {
    const double px = box.x + (x - x0) / (x1 - x0) * box.width,
                 py = box.y + box.height - (y - y0) / (y1 - y0) * box.height;
    const double limit = 1 << 20;
    return {static_cast<int>(std::clamp(px, -limit, limit) * (1 << kShift)),
            static_cast<int>(std::clamp(py, -limit, limit) * (1 << kShift))};
  }
  void text(const std::string& s, double x, double y, double size, double align = 0,
            const cv::Scalar& colour = kInk) const {
    int base = 0;
    const cv::Size extent = cv::getTextSize(s, cv::FONT_HERSHEY_SIMPLEX, size, 1, &base);
    cv::putText(image, s, cv::Point2d(x - align * extent.width, y), cv::FONT_HERSHEY_SIMPLEX, size, colour, 1,
                cv::LINE_AA);
  }
};

void find_range(const Plot& plot, std::vector<double> PlotSeries::*values, std::array<double, 2>& range) {
  if (range[0] != range[1]) return;
  double low = 1e300, high = -1e300;
  for (const bool dots : {false, true}) {  // dots (map points) set the range only when there is no other series
    for (const PlotSeries& s : plot.series) {
      if ((s.style == PlotSeries::Style::dots) != dots) continue;
      for (const double v : s.*values) {
        if (!std::isfinite(v)) continue;
        low = std::min(low, v);
        high = std::max(high, v);
      }
    }
    if (low <= high) break;
  }
  if (low > high) low = 0, high = 1;
  const double margin = high > low ? 0.05 * (high - low) : 0.5;
  range = {low - margin, high + margin};
}

// Between the ends of an axis there must be numbers for its ticks, however far from zero they are.
void widen(std::array<double, 2>& range) {
  constexpr double kLeast = 1e-12;
  const double margin = kLeast * std::max(std::abs(range[0]), std::abs(range[1]));
  range = {range[0] - margin, range[1] + margin};
}

void draw_axes(const Canvas& c, const Plot& plot) {
  const double step_x = tick_step(c.x1 - c.x0, std::max(2, static_cast<int>(c.box.width / 110)));
  const double step_y = tick_step(c.y1 - c.y0, std::max(2, static_cast<int>(c.box.height / 60)));
  for (double x = std::ceil(c.x0 / step_x) * step_x; x <= c.x1; x += step_x) {
    cv::line(c.image, c.at(x, c.y0), c.at(x, c.y1), kGrid, 1, cv::LINE_AA, kShift);
    c.text(tick_text(x, step_x), c.at(x, 0).x / double(1 << kShift), c.box.y + c.box.height + 18, 0.42, 0.5);
  }
  for (double y = std::ceil(c.y0 / step_y) * step_y; y <= c.y1; y += step_y) {
    cv::line(c.image, c.at(c.x0, y), c.at(c.x1, y), kGrid, 1, cv::LINE_AA, kShift);
    c.text(tick_text(y, step_y), c.box.x - 8, c.at(0, y).y / double(1 << kShift) + 4, 0.42, 1);
  }
  c.text(plot.title, c.box.x, 24, 0.6);
  c.text(plot.x_label, c.box.x + c.box.width / 2, c.box.y + c.box.height + 40, 0.45, 0.5);
  // The label of the y axis is rotated by 90 degrees.
  int base = 0;
  const cv::Size extent = cv::getTextSize(plot.y_label, cv::FONT_HERSHEY_SIMPLEX, 0.45, 1, &base);
  if (extent.width > 0) {
    cv::Mat label(extent.height + base + 2, extent.width + 2, CV_8UC3, cv::Scalar::all(255)), turned;
    cv::putText(label, plot.y_label, {0, extent.height}, cv::FONT_HERSHEY_SIMPLEX, 0.45, kInk, 1, cv::LINE_AA);
    cv::rotate(label, turned, cv::ROTATE_90_COUNTERCLOCKWISE);
    const cv::Rect place(6, std::max(0, static_cast<int>(c.box.y + (c.box.height - turned.rows) / 2)), turned.cols,
                         turned.rows);
    if ((place & cv::Rect(0, 0, c.image.cols, c.image.rows)) == place) turned.copyTo(c.image(place));
  }
}

void draw_series(const Canvas& c, const PlotSeries& s) {
  const cv::Scalar colour = bgr(s.colour);
  for (size_t i = 0; i < s.x.size(); ++i) {
    if (!std::isfinite(s.x[i]) || !std::isfinite(s.y[i])) continue;
    const cv::Point p = c.at(s.x[i], s.y[i]);
    if (s.style == PlotSeries::Style::line) {
      if (i > 0 && std::isfinite(s.x[i - 1]) && std::isfinite(s.y[i - 1])) {
        cv::line(c.image, c.at(s.x[i - 1], s.y[i - 1]), p, colour, std::max(1, static_cast<int>(std::lround(s.width))),
                 cv::LINE_AA, kShift);
      }
    } else {
      cv::circle(c.image, p, static_cast<int>(s.width * (1 << kShift)), colour,
                 s.style == PlotSeries::Style::dots ? cv::FILLED : 1, cv::LINE_AA, kShift);
    }
  }
}

void draw_legend(const Canvas& c, const Plot& plot) {
  double x = c.box.x + c.box.width;
  for (auto s = plot.series.rbegin(); s != plot.series.rend(); ++s) {
    if (s->label.empty()) continue;
    int base = 0;
    x -= cv::getTextSize(s->label, cv::FONT_HERSHEY_SIMPLEX, 0.45, 1, &base).width;
    c.text(s->label, x, 24, 0.45);
    cv::line(c.image, cv::Point2d(x - 22, 20), cv::Point2d(x - 6, 20), bgr(s->colour), 3, cv::LINE_AA);
    x -= 36;
  }
}

cv::Mat paint(const Plot& plot) {
  Canvas c;
  c.image = cv::Mat(plot.height, plot.width, CV_8UC3, cv::Scalar::all(255));
  c.box = cv::Rect2d(kLeft, kTop, plot.width - kLeft - kRight, plot.height - kTop - kBottom);
  std::array<double, 2> xr = plot.x_range, yr = plot.y_range;
  find_range(plot, &PlotSeries::x, xr);
  find_range(plot, &PlotSeries::y, yr);
  widen(xr);
  widen(yr);
  if (plot.equal_aspect) {
    const double unit = std::max((xr[1] - xr[0]) / c.box.width, (yr[1] - yr[0]) / c.box.height);  // units per pixel
    for (auto [range, pixels] : {std::pair{&xr, c.box.width}, std::pair{&yr, c.box.height}}) {
      const double middle = ((*range)[0] + (*range)[1]) / 2;
      *range = {middle - unit * pixels / 2, middle + unit * pixels / 2};
    }
  }
  c.x0 = xr[0], c.x1 = xr[1], c.y0 = yr[0], c.y1 = yr[1];
  draw_axes(c, plot);
  // Drawing into a copy of the box clips everything outside it.
  Canvas inner = c;
  inner.image = c.image.clone();
  for (const PlotSeries& s : plot.series) draw_series(inner, s);
  const cv::Rect box(static_cast<int>(c.box.x), static_cast<int>(c.box.y), static_cast<int>(c.box.width),
                     static_cast<int>(c.box.height));
  inner.image(box).copyTo(c.image(box));
  cv::rectangle(c.image, box, kFrame, 1, cv::LINE_AA);
  draw_legend(c, plot);
  return c.image;
}

}  // namespace

Result<std::string> draw(const std::vector<Plot>& plots) {
  std::vector<cv::Mat> images;
  for (const Plot& plot : plots) images.push_back(paint(plot));
  cv::Mat all;
  cv::vconcat(images, all);
  return io::encode_image(".png", all);
}

Result<void> write_plots(const std::filesystem::path& file, const std::vector<Plot>& plots) {
  const auto png = draw(plots);
  if (!png) return tl::unexpected(png.error());
  return write_atomically(file, io::marked_picture(*png));
}

}  // namespace covis
