// SPDX-License-Identifier: Apache-2.0
// Small plots as PNG: lines, dots and marks over axes with ticks.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "covis/core/error.h"

namespace covis {

struct PlotColour {
  uint8_t r = 0, g = 0, b = 0;
};

struct PlotSeries {
  enum class Style { line, dots, marks };
  std::string label;         // text in the legend; empty: not listed
  std::vector<double> x, y;  // NaN breaks a line
  PlotColour colour;
  Style style = Style::line;
  double width = 1.5;  // width of a line, or radius of dots and marks, pixels
};

struct Plot {
  std::string title, x_label, y_label;
  std::vector<PlotSeries> series;
  bool equal_aspect = false;       // same scale in x and y, for paths
  int width = 1000, height = 420;  // pixels
  // The range drawn. When both ends are equal it is computed from the series that are not dots.
  std::array<double, 2> x_range{0, 0}, y_range{0, 0};
};

// Returns the bytes of a PNG file: the plots one below the other. They must have the same width. Error: the
// installation has no part that writes images.
Result<std::string> draw(const std::vector<Plot>& plots);
// Draws them into a PNG file, whatever its name, with a note that Covis made it.
Result<void> write_plots(const std::filesystem::path& file, const std::vector<Plot>& plots);

}  // namespace covis
