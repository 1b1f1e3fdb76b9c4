// SPDX-License-Identifier: Apache-2.0
#include "covis/eval/plot.h"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/imgcodecs.hpp>
#include <vector>

#include "covis/eval/charts.h"

namespace covis {
namespace {

TEST(PlotTest, NothingAndOnePointAndNanCanBeDrawn) {
  const double nan = std::nan("");
  for (const std::vector<double>& v : std::vector<std::vector<double>>{{}, {1}, {nan}, {nan, 1, nan, 2, 3}}) {
    Plot plot{.title = "t", .x_label = "x", .y_label = "y", .series = {{"s", v, v, kBlue}}};
    const auto png = draw({plot, plot});
    ASSERT_TRUE(png) << png.error().message;
    const cv::Mat image = cv::imdecode(std::vector<uint8_t>(png->begin(), png->end()), cv::IMREAD_COLOR);
    EXPECT_EQ(image.size(), cv::Size(plot.width, 2 * plot.height));
  }
}

// A camera that stands, in the coordinates of a country: its path is as wide as the last digit of a number.
TEST(PlotTest, AxesFarFromZeroHaveAnEnd) {
  for (const double far : {5e6, 1e8, 1e9, 999999999999.0}) {
    const std::vector<double> path{far, std::nextafter(far, 2 * far), far};
    Plot plot{.title = "t", .x_label = "x", .y_label = "y", .series = {{"s", path, path, kBlue}}, .equal_aspect = true};
    EXPECT_TRUE(draw({plot})) << far;
    plot.x_range = {far, path[1]};
    EXPECT_TRUE(draw({plot})) << far;
  }
}

}  // namespace
}  // namespace covis
