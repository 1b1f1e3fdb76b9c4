// SPDX-License-Identifier: Apache-2.0
#include "covis/eval/charts.h"

#include <gmock/gmock.h>

#include <vector>

namespace covis {
namespace {

using testing::HasSubstr;

TEST(Charts, TheWidestAxesAreThoseOfTheMotion) {
  const auto axes = [](const Eigen::Vector3d& size) {
    std::vector<Eigen::Vector3d> path;
    for (int k = 0; k < 20; ++k) path.emplace_back((k % 2) * size.x(), (k / 2 % 2) * size.y(), (k / 4 % 2) * size.z());
    return widest_axes(path);
  };
  EXPECT_EQ(axes({5, 0.1, 3}), (std::array<int, 2>{0, 2}));
  EXPECT_EQ(axes({5, 3, 0.1}), (std::array<int, 2>{0, 1}));
  EXPECT_EQ(axes({0.1, 3, 5}), (std::array<int, 2>{1, 2}));
}

TEST(Charts, ASeriesTakesTheAxesOfItsPlot) {
  const PlotSeries series = path_series("path", {{1, 2, 3}, {4, 5, 6}}, {0, 2}, kBlue);
  EXPECT_THAT(series.x, testing::ElementsAre(1, 4));
  EXPECT_THAT(series.y, testing::ElementsAre(3, 6));
  EXPECT_EQ(series.label, "path");
  EXPECT_TRUE(path_plot({0, 2}).equal_aspect);
}

TEST(Charts, TextIsEscapedInPages) {
  EXPECT_THAT(html_escaped("a < b & c"), HasSubstr("a &lt; b &amp; c"));
  const std::string page = html_page("5 < 6", "<p>body</p>");
  EXPECT_THAT(page, testing::AllOf(HasSubstr("5 &lt; 6"), HasSubstr("<p>body</p>"), HasSubstr("</html>")));
}

// RFC 4648, section 10.
TEST(Charts, PicturesAreInThePage) {
  EXPECT_THAT(html_image("foobar", "what"), HasSubstr("base64,Zm9vYmFy"));
  EXPECT_THAT(html_image("fooba", "what"), HasSubstr("base64,Zm9vYmE="));
  EXPECT_THAT(html_image("foob", "what"), HasSubstr("base64,Zm9vYg=="));
}

}  // namespace
}  // namespace covis
