// SPDX-License-Identifier: Apache-2.0
#include "map_picture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "covis/exchange/scene.h"

namespace covis::app {
namespace {

constexpr PlotColour kPoints{150, 160, 175}, kPath{200, 40, 30};
constexpr int kWidth = 1000, kHeight = 800;

// A range that holds the middle 98 % of the values and all of `whole`, with a margin: a few points lie far away.
std::array<double, 2> range_of(std::vector<double> values, const std::vector<double>& whole) {
  if (values.empty()) values = whole;
  if (values.empty()) return {-1, 1};
  std::sort(values.begin(), values.end());
  const auto at = [&](double share) {
    return values[static_cast<size_t>(share * static_cast<double>(values.size() - 1))];
  };
  double low = at(0.01), high = at(0.99);
  for (const double v : whole) {
    low = std::min(low, v);
    high = std::max(high, v);
  }
  const double margin = std::max(1e-3, 0.05 * (high - low));
  return {low - margin, high + margin};
}

Plot plot_of(const exchange::Scene& scene, const std::string& title) {
  const Eigen::Matrix3d to_above = exchange::seen_from_above(scene);
  PlotSeries points{
      .label = "points", .x = {}, .y = {}, .colour = kPoints, .style = PlotSeries::Style::dots, .width = 1};
  PlotSeries path{.label = "key frames", .x = {}, .y = {}, .colour = kPath, .width = 2};
  const auto add = [&](const Eigen::Vector3d& p, PlotSeries& to) {
    const Eigen::Vector3d seen = to_above * p;
    to.x.push_back(seen.x());
    to.y.push_back(seen.y());
  };
  for (const exchange::ScenePoint& point : scene.points) add(point.position, points);
  for (const exchange::SceneView& view : scene.views) add(view.T_cw.inverse().t(), path);
  Plot plot;
  plot.title = title;
  plot.x_label = "to the right of the first key frame";
  plot.y_label = "ahead of it";
  plot.x_range = range_of(points.x, path.x);
  plot.y_range = range_of(points.y, path.y);
  plot.series = {std::move(points), std::move(path)};
  plot.equal_aspect = true;
  plot.width = kWidth;
  plot.height = kHeight;
  return plot;
}

}  // namespace

std::vector<Plot> plots_from_above(const Map& map, const Camera& camera, const std::string& title) {
  std::vector<Plot> plots;
  for (const exchange::Scene& scene : exchange::scenes_of(map, camera)) {
    const std::string which = map.submaps().size() > 1 ? ", map " + std::to_string(plots.size()) : "";
    plots.push_back(plot_of(scene, title + which));
  }
  if (plots.empty()) plots.push_back(Plot{.title = title + ": empty", .x_label = "", .y_label = "", .series = {}});
  return plots;
}

}  // namespace covis::app
