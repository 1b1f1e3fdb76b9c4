// SPDX-License-Identifier: Apache-2.0
// Small plots as PNG: lines, dots and marks over axes with ticks.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace covis {

struct PlotColour {
  uint8_t r = 0, g = 0, b = 0;
};

struct PlotSeries {
  enum class Style { line, dots, marks };
  std::string label;         // in the legend; empty: not listed
  std::vector<double> x, y;  // NaN breaks a line
  PlotColour colour;
  Style style = Style::line;
  double width = 1.5;  // width of a line, or radius of dots and marks, pixels
};

struct Plot {
  std::string title, x_label, y_label;
  std::vector<PlotSeries> series;
  bool equal_aspect = false;       // one unit is as long in x as in y: for paths
  int width = 1000, height = 420;  // pixels
  // The part shown; when first equals second it is taken from the series that are not dots.
  std::array<double, 2> x_range{0, 0}, y_range{0, 0};
};

// The bytes of a PNG file.
std::string draw(const Plot& plot);
// One below the other; they must be equally wide.
std::string draw_stacked(const std::vector<Plot>& plots);

}  // namespace covis
