// SPDX-License-Identifier: Apache-2.0
// Drawing code shared by the report of a run and the picture of an evaluation, and the HTML page that holds them.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "covis/eval/evaluation.h"
#include "covis/eval/plot.h"

namespace covis {

inline constexpr PlotColour kBlue{31, 105, 190}, kRed{205, 55, 45}, kGrey{175, 180, 188}, kGreen{30, 140, 80},
    kOrange{225, 140, 20}, kBlack{40, 40, 40};

// Returns the two axes along which the path spreads most: the view "from above" when the vertical is unknown.
std::array<int, 2> widest_axes(const std::vector<Eigen::Vector3d>& path);
// Returns an empty plot with these axes, in metres.
Plot path_plot(const std::array<int, 2>& axes);
PlotSeries path_series(const std::string& label, const std::vector<Eigen::Vector3d>& points,
                       const std::array<int, 2>& axes, PlotColour colour);
Plot error_plot(const Evaluation& evaluation);

std::string base64(const std::string& bytes);
std::string html_escaped(const std::string& text);
std::string html_image(const std::string& png, const std::string& what);
Result<std::string> html_plot(const Plot& plot, const std::string& what);  // error: as draw()
// Returns a self-contained page. `body` is HTML, the title is plain text.
std::string html_page(const std::string& title, const std::string& body);

}  // namespace covis
