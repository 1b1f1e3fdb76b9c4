// SPDX-License-Identifier: Apache-2.0
#include "covis/eval/report.h"

#include <gmock/gmock.h>

#include <cmath>
#include <cstdlib>
#include <opencv2/imgcodecs.hpp>

#include "covis/core/test_folder.h"
#include "covis/eval/charts.h"
#include "covis/io/files.h"

namespace covis {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

// A quarter of a circle in the xz plane, beside the truth by `aside` metres.
Trajectory arc(double aside) {
  Trajectory path;
  for (int i = 0; i <= 60; ++i) {
    const double a = i * M_PI / 120;
    path.push_back({Timestamp{i} * 100'000'000,
                    SE3(so3_exp({0, a, 0}), Eigen::Vector3d(10 * std::cos(a) + aside, 0, 10 * std::sin(a)))});
  }
  return path;
}

// Pixels of the colour in the rows [first, last) of an image.
int count(const cv::Mat& image, PlotColour colour, int first, int last) {
  cv::Mat found;
  const cv::Scalar bgr(colour.b, colour.g, colour.r);
  cv::inRange(image.rowRange(first, last), bgr, bgr, found);
  return cv::countNonZero(found);
}

class Picture : public testing::Test {
 protected:
  const TemporaryFolder temporary;
  const fs::path folder = temporary.path();
  const Result<Evaluation> evaluation = evaluate(arc(2), arc(0), {.align = AlignMode::none});
};

TEST_F(Picture, ShowsBothPathsAndTheErrorBelow) {
  ASSERT_TRUE(evaluation);
  ASSERT_TRUE(write_picture(folder / "errors.png", "title", *evaluation));
  const cv::Mat image = cv::imread((folder / "errors.png").string());
  ASSERT_EQ(image.cols, 1000);
  ASSERT_EQ(image.rows, 760 + 420);
  // Each path runs over most of the upper plot, the error (2 m all along) right across the lower one.
  EXPECT_GT(count(image, kBlue, 60, 700), 500);
  EXPECT_GT(count(image, kRed, 60, 700), 500);
  EXPECT_GT(count(image, kRed, 800, 1120), 800);
  EXPECT_EQ(count(image, kBlue, 800, 1120), 0);
}

TEST_F(Picture, TheTwoAxesAreThoseOfTheMotion) {
  std::vector<Eigen::Vector3d> path;
  for (const StampedPose& p : arc(0)) path.push_back(p.T_wc.t());
  EXPECT_EQ(widest_axes(path), (std::array{0, 2}));
  for (Eigen::Vector3d& p : path) p = {p.y(), p.x(), p.z()};
  EXPECT_EQ(widest_axes(path), (std::array{1, 2}));
  for (Eigen::Vector3d& p : path) p = {p.y(), p.z(), p.x()};
  EXPECT_EQ(widest_axes(path), (std::array{0, 1}));
}

TEST_F(Picture, AsAPageItHoldsTheTableAndNeedsNoOtherFile) {
  ASSERT_TRUE(evaluation);
  ASSERT_TRUE(write_picture(folder / "errors.html", "a < b & \"c\"", *evaluation));
  const auto page = io::read_text(folder / "errors.html");
  ASSERT_TRUE(page);
  EXPECT_THAT(*page, HasSubstr("<h1>a &lt; b &amp; &quot;c&quot;</h1>"));
  EXPECT_THAT(*page, HasSubstr("ATE"));
  EXPECT_THAT(*page, HasSubstr("</html>"));
  EXPECT_THAT(*page, testing::Not(HasSubstr("src=\"http")));
  size_t images = 0;
  for (size_t at = 0; (at = page->find("data:image/png;base64,iVBORw0KGgo", at)) != std::string::npos; ++at) ++images;
  EXPECT_EQ(images, 2u);
}

TEST_F(Picture, AnotherEndingIsAnError) {
  ASSERT_TRUE(evaluation);
  const auto written = write_picture(folder / "errors.svg", "title", *evaluation);
  ASSERT_FALSE(written);
  EXPECT_THAT(written.error().message, testing::AllOf(HasSubstr("errors.svg"), HasSubstr(".png or .html")));
  EXPECT_TRUE(fs::is_empty(folder));
}

// A run's report with hand-made frames: three losses apart from each other, and odd characters.
TEST_F(Picture, AReportTellsWhatWasLostAndWhy) {
  const Trajectory estimate = arc(0), truth = arc(1);
  ReportInput input;
  input.title = "<run>";
  input.estimate = estimate;
  input.key_frames = {estimate.front(), estimate.back()};
  input.truth = &truth;
  input.points = {{1, 2, 3}};
  for (int i = 0; i < 10; ++i) input.frames.push_back({i, "", "", 5, 100, i == 0});
  for (const int i : {2, 3, 4, 8}) input.frames[static_cast<size_t>(i)] = {i, "lost", "12 < 30 matches", 5, 0, false};
  input.summary = {{"frames", "10 & more"}};
  ASSERT_TRUE(write_report(folder, input));
  const auto page = io::read_text(folder / "report.html");
  ASSERT_TRUE(page);
  for (const char* text : {"<h1>&lt;run&gt;</h1>", "10 &amp; more", "2 – 4</td><td>lost</td><td>12 &lt; 30 matches",
                           "8 – 8</td>", "error over time"})
    EXPECT_THAT(*page, HasSubstr(text));
  EXPECT_FALSE(cv::imread((folder / "trajectory.png").string()).empty());
}

TEST_F(Picture, AReportOfNothingIsWrittenToo) {
  ReportInput input;
  input.title = "empty";
  ASSERT_TRUE(write_report(folder, input));
  EXPECT_TRUE(fs::exists(folder / "report.html"));
  EXPECT_FALSE(fs::exists(folder / "trajectory.png"));
}

}  // namespace
}  // namespace covis
