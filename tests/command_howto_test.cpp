// SPDX-License-Identifier: Apache-2.0
// Commands of docs/howto.md that no other test of the command runs.
#include <cmath>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "command_results.h"
#include "command_video.h"
#include "covis/geometry/se3.h"
#include "covis/io/camera_file.h"

namespace covis {
namespace {

using CommandHowto = CommandTest;

TEST_F(CommandHowto, AVideoGivesAPathAndAMap) {
  constexpr int kFrames = 30;
  const fs::path recording = render("mono", kFrames), video = folder / "walk.avi", out = folder / "result";
  ASSERT_NO_FATAL_FAILURE(write_video(recording, video, 10));
  const Outcome run = covis({"run", video, "--camera", recording / "camera.yaml", "--out", out});
  ASSERT_EQ(run.code, 0) << run.error;
  EXPECT_EQ(expect_results(out), kFrames);
  EXPECT_GE(parsed(out / "summary.json")["frames_tracked"].get<int>(), 20);
}

// A printed checkerboard with 9 x 6 inner corners, seen by a camera without distortion from many sides.
TEST_F(CommandHowto, ABoardGivesACameraFile) {
  constexpr int kPixels = 40;  // side of a square on the print
  constexpr double kSquare = 0.025, kFocal = 410;
  cv::Mat print(9 * kPixels, 12 * kPixels, CV_8U, cv::Scalar(235));
  for (int y = 0; y < 7; ++y) {
    for (int x = y % 2; x < 10; x += 2) print(cv::Rect((x + 1) * kPixels, (y + 1) * kPixels, kPixels, kPixels)) = 20;
  }
  const cv::Matx33d K(kFocal, 0, 240, 0, kFocal, 180, 0, 0, 1);
  const double metres = kSquare / kPixels;
  fs::create_directories(folder / "views");
  for (int i = 0; i < 14; ++i) {
    const Eigen::Matrix3d R = so3_exp({0.5 * std::sin(1.3 * i), 0.5 * std::cos(1.7 * i), 0.2 * std::sin(0.7 * i)});
    const double z = 0.32 + 0.012 * i;
    const Eigen::Vector3d centre(0.12 * z * std::sin(2.1 * i), 0.1 * z * std::cos(2.9 * i), z);
    const Eigen::Vector3d t = centre - R * Eigen::Vector3d(print.cols * metres / 2, print.rows * metres / 2, 0);
    const cv::Matx33d plane(metres * R(0, 0), metres * R(0, 1), t[0], metres * R(1, 0), metres * R(1, 1), t[1],
                            metres * R(2, 0), metres * R(2, 1), t[2]);
    cv::Mat view;
    cv::warpPerspective(print, view, K * plane, {480, 360}, cv::INTER_LINEAR, cv::BORDER_CONSTANT, cv::Scalar(210));
    cv::GaussianBlur(view, view, {3, 3}, 0);
    cv::imwrite((folder / "views" / (std::to_string(100 + i) + ".png")).string(), view);
  }
  const fs::path file = folder / "phone.yaml", picture = folder / "residuals.png";
  const Outcome made = covis(
      {"calibrate", folder / "views", "--board", "9x6", "--square", "0.025", "--out", file, "--picture", picture});
  ASSERT_EQ(made.code, 0) << made.error;
  EXPECT_EQ(text_of(picture).substr(1, 3), "PNG");
  const auto found = io::load_camera(file);
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_NEAR(found->camera.pinhole.fx, kFocal, 0.01 * kFocal);
  EXPECT_NEAR(found->camera.pinhole.cx, 240, 4);
  EXPECT_EQ(found->camera.width, 480);
}

}  // namespace
}  // namespace covis
