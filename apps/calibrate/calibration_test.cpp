// SPDX-License-Identifier: Apache-2.0
#include "apps/calibrate/calibration.h"

#include <gmock/gmock.h>

#include <Eigen/Geometry>
#include <opencv2/aruco/charuco.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>

#include "apps/calibrate/board_frames.h"
#include "covis/core/random.h"
#include "covis/core/test_folder.h"
#include "covis/geometry/se3.h"

namespace covis::app {
namespace {

constexpr int kWidth = 480, kHeight = 360;

Camera brown() {
  return {kWidth, kHeight, {410, 412, 236, 184, 0}, Distortion::brown_conrady, {-0.25, 0.08, 0.001, -0.0005, 0}};
}
Camera fisheye() {
  return {kWidth, kHeight, {240, 241, 238, 182, 0}, Distortion::kannala_brandt, {0.02, -0.005, 0.001, 0, 0}};
}

// The print on a board: grey values at a place in metres.
struct Print {
  cv::Mat image;
  double pixels_per_metre;
  uint8_t at(double x, double y) const {
    const int u = static_cast<int>(x * pixels_per_metre), v = static_cast<int>(y * pixels_per_metre);
    if (x < 0 || y < 0 || u >= image.cols || v >= image.rows) return 210;  // the wall behind
    return image.at<uint8_t>(v, u);
  }
};

// The view of a board by a camera, four rays a pixel.
cv::Mat render(const Print& print, const Camera& camera, const SE3& T_cb) {
  cv::Mat image(camera.height, camera.width, CV_8U);
  const SE3 T_bc = T_cb.inverse();
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) {
      int sum = 0;
      for (int k = 0; k < 4; ++k) {
        const auto ray = camera.unproject({u - 0.25 + 0.5 * (k % 2), v - 0.25 + 0.5 * (k / 2)});
        const Eigen::Vector3d d = ray ? Eigen::Vector3d(T_bc.R() * *ray) : Eigen::Vector3d(0, 0, -1);
        const double s = -T_bc.t().z() / d.z();
        sum += d.z() > 0 ? print.at(T_bc.t().x() + s * d.x(), T_bc.t().y() + s * d.y()) : 210;
      }
      image.at<uint8_t>(v, u) = static_cast<uint8_t>(sum / 4);
    }
  }
  return image;
}

// A board of the given size in front of the camera, tilted and moved at random.
SE3 some_pose(Random& random, double width, double height, double near, double far, double spread) {
  const Eigen::Matrix3d R = (Eigen::AngleAxisd(random.uniform(-0.6, 0.6), Eigen::Vector3d::UnitX()) *
                             Eigen::AngleAxisd(random.uniform(-0.6, 0.6), Eigen::Vector3d::UnitY()) *
                             Eigen::AngleAxisd(random.uniform(-0.3, 0.3), Eigen::Vector3d::UnitZ()))
                                .toRotationMatrix();
  const double z = random.uniform(near, far);
  const Eigen::Vector3d centre(random.uniform(-spread, spread) * z, random.uniform(-0.8, 0.8) * spread * z, z);
  return SE3(R, centre - R * Eigen::Vector3d(width / 2, height / 2, 0));
}

// The greatest distance between where two cameras see a place, over the middle of the image, pixels.
double greatest_difference(const Camera& a, const Camera& b) {
  double greatest = 0;
  for (int v = 60; v < kHeight - 60; v += 20) {
    for (int u = 80; u < kWidth - 80; u += 20)
      greatest = std::max(
          greatest,
          (*b.project(*a.unproject({static_cast<double>(u), static_cast<double>(v)})) - Eigen::Vector2d(u, v)).norm());
  }
  return greatest;
}

struct Shown {
  Print print;
  Board board;
  double near, far;  // metres
  double spread;     // how far the board's centre goes to each side, as a share of its distance
};

Shown checkerboard() {
  constexpr double kSquare = 0.03;
  constexpr int kPixels = 60;  // a square
  cv::Mat image(9 * kPixels, 12 * kPixels, CV_8U, cv::Scalar(235));
  for (int y = 0; y < 7; ++y) {
    for (int x = 0; x < 10; ++x) {
      if ((x + y) % 2 == 0) image(cv::Rect((x + 1) * kPixels, (y + 1) * kPixels, kPixels, kPixels)) = 20;
    }
  }
  return {{image, kPixels / kSquare}, {.columns = 9, .rows = 6, .square = kSquare}, 0.35, 0.8, 0.3};
}

Shown charuco() {
  constexpr double kSquare = 0.04;
  constexpr int kPixels = 60;
  Board board{.kind = Board::Kind::charuco,
              .columns = 8,
              .rows = 6,
              .square = kSquare,
              .marker = 0.03,
              .dictionary = *dictionary_of("4X4_50")};
  cv::Mat image;
  cv::aruco::CharucoBoard::create(8, 6, 0.04f, 0.03f, cv::aruco::getPredefinedDictionary(board.dictionary))
      ->draw({8 * kPixels, 6 * kPixels}, image, 0, 1);
  return {{image, kPixels / kSquare}, board, 0.15, 0.4, 0.7};
}

std::vector<BoardView> views_of(const Shown& shown, const Camera& camera, int count, size_t least) {
  Random random(4);
  const BoardFinder finder(shown.board);
  const double width = shown.print.image.cols / shown.print.pixels_per_metre,
               height = shown.print.image.rows / shown.print.pixels_per_metre;
  std::vector<BoardView> views;
  for (int i = 0; i < count; ++i) {
    const SE3 pose = some_pose(random, width, height, shown.near, shown.far, shown.spread);
    if (auto view = finder.find(render(shown.print, camera, pose))) views.push_back(std::move(*view));
  }
  EXPECT_GE(views.size(), least);
  return views;
}

TEST(Calibration, FindsTheCameraFromACheckerboard) {
  const auto views = views_of(checkerboard(), brown(), 18, 10);
  const auto made = calibrate(views, {kWidth, kHeight}, Distortion::brown_conrady);
  ASSERT_TRUE(made) << made.error().message;
  EXPECT_NEAR(made->camera.pinhole.fx, 410, 2);
  EXPECT_NEAR(made->camera.pinhole.fx, 410, 5 * made->fx_sigma) << "and it knows how well";
  EXPECT_NEAR(made->camera.pinhole.cx, 236, 2);
  EXPECT_LT(made->rms, 0.3);
  EXPECT_LT(greatest_difference(brown(), made->camera), 1);
  const Plot plot = residual_plot(*made);
  EXPECT_EQ(plot.series.front().x.size(), made->residuals.size());
  EXPECT_TRUE(draw({plot}));
}

TEST(Calibration, FindsAFisheyeFromACharucoBoard) {
  const auto views = views_of(charuco(), fisheye(), 16, 9);
  const auto made = calibrate(views, {kWidth, kHeight}, Distortion::kannala_brandt);
  ASSERT_TRUE(made) << made.error().message;
  EXPECT_EQ(made->camera.distortion, Distortion::kannala_brandt);
  EXPECT_NEAR(made->camera.pinhole.fx, 240, 3);
  EXPECT_LT(greatest_difference(fisheye(), made->camera), 1);
}

// Corners as a perfect detector would find them.
std::vector<BoardView> exact_views(int count) {
  Random random(7);
  std::vector<BoardView> views;
  for (int i = 0; i < count; ++i) {
    const SE3 pose = some_pose(random, 0.3, 0.2, 0.5, 0.9, 0.25);
    BoardView view;
    view.frame = i;
    for (int k = 0; k < 54; ++k) {
      const Eigen::Vector3d corner(0.03 * (k % 9), 0.03 * (k / 9), 0);
      const auto pixel = brown().project(pose * corner);
      view.corners.emplace_back(static_cast<float>(corner.x()), static_cast<float>(corner.y()), 0.0f);
      view.pixels.emplace_back(static_cast<float>(pixel->x()), static_cast<float>(pixel->y()));
    }
    views.push_back(std::move(view));
  }
  return views;
}

TEST(Calibration, AViewThatDoesNotFitIsLeftOut) {
  std::vector<BoardView> views = exact_views(12);
  for (size_t k = 0; k < views[5].pixels.size(); ++k) views[5].pixels[k].x += k % 2 ? 4.0f : -4.0f;
  const auto made = calibrate(views, {kWidth, kHeight}, Distortion::brown_conrady);
  ASSERT_TRUE(made) << made.error().message;
  EXPECT_GE(made->left_out, 1u);
  EXPECT_NEAR(made->camera.pinhole.fx, 410, 0.5);
}

TEST(Calibration, TooFewViewsAreAnError) {
  const auto made = calibrate(exact_views(5), {kWidth, kHeight}, Distortion::brown_conrady);
  ASSERT_FALSE(made);
  EXPECT_THAT(made.error().message, testing::HasSubstr("found in 5 different views"));
}

TEST(BoardViews, ThatAreAlikeAreNotAllChosen) {
  std::vector<BoardView> views = exact_views(10);
  const std::vector<BoardView> once = views;
  views.insert(views.end(), once.begin(), once.end());
  EXPECT_EQ(choose_views(views, {kWidth, kHeight}, 60).size(), 10u);
  const auto few = choose_views(views, {kWidth, kHeight}, 4);
  EXPECT_LE(few.size(), 4u);
  EXPECT_GE(few.size(), 1u);
  EXPECT_TRUE(choose_views({}, {kWidth, kHeight}, 4).empty());
}

class BoardFiles : public testing::Test {
 protected:
  BoardFiles() {
    Random random(4);
    const Shown shown = checkerboard();
    for (int i = 0; i < 3; ++i)
      images.push_back(render(shown.print, brown(), some_pose(random, 0.36, 0.27, 0.5, 0.7, 0)));
    images.insert(images.begin() + 1, cv::Mat(kHeight, kWidth, CV_8U, cv::Scalar(128)));
  }
  Result<BoardFrames> look(const std::string& name, int stride = 0) const {
    return look_for_board((folder / name).string(), BoardFinder(checkerboard().board), stride, stop);
  }
  std::string error(const std::string& name) const {
    const auto seen = look(name);
    return seen ? std::string() : seen.error().message;
  }
  const TemporaryFolder folder;
  const std::atomic<int> stop{0};
  std::vector<cv::Mat> images;  // the second without a board
};

TEST_F(BoardFiles, AreImagesOrAVideo) {
  std::filesystem::create_directories(folder / "images");
  const auto video_of = [&](const char* name, bool coloured) {
    return cv::VideoWriter((folder / name).string(), cv::VideoWriter::fourcc('M', 'J', 'P', 'G'), 10, {kWidth, kHeight},
                           coloured);
  };
  cv::VideoWriter video = video_of("board.avi", true), grey = video_of("grey.avi", false);
  for (size_t i = 0; i < images.size(); ++i) {
    cv::imwrite((folder / ("images/" + std::to_string(i) + ".png")).string(), images[i]);
    cv::Mat colour;
    cv::cvtColor(images[i], colour, cv::COLOR_GRAY2BGR);
    for (int k = 0; k < 5; ++k) {
      video.write(colour);
      grey.write(images[i]);
    }
  }
  video.release();
  grey.release();
  write_file(folder / "images/9.png", "no image");
  for (const std::string name : {"images", "board.avi", "grey.avi"}) {
    const auto seen = look(name);
    ASSERT_TRUE(seen) << seen.error().message;
    EXPECT_EQ(seen->frames, 4);
    ASSERT_EQ(seen->views.size(), 3u);
    EXPECT_EQ(seen->views[1].frame, name == "images" ? 2 : 10);
    EXPECT_EQ(seen->image, cv::Size(kWidth, kHeight));
  }
  EXPECT_EQ(look("images", 2)->views.size(), 2u);
}

TEST_F(BoardFiles, ThatAreNoneAreNamed) {
  std::filesystem::create_directories(folder / "empty");
  write_file(folder / "text.mp4", "no video");
  EXPECT_THAT(error("empty"), testing::HasSubstr("empty: there are no images"));
  EXPECT_THAT(error("none"), testing::HasSubstr("none: there is no such"));
  EXPECT_THAT(error("text.mp4"), testing::HasSubstr("text.mp4: it is not a video that can be read (MP4"));
  cv::imwrite((folder / "empty/0.png").string(), images[1]);
  cv::imwrite((folder / "empty/1.png").string(), images[1](cv::Rect(0, 0, 99, 99)));
  EXPECT_THAT(error("empty"), testing::HasSubstr("image 1 is 99x99, those before 480x360"));
}

TEST(BoardViews, AnImageWithoutABoardHasNone) {
  const cv::Mat empty(kHeight, kWidth, CV_8U, cv::Scalar(128));
  EXPECT_FALSE(BoardFinder(checkerboard().board).find(empty));
  EXPECT_FALSE(BoardFinder(charuco().board).find(empty));
  EXPECT_THAT(dictionary_of("9X9_1").error().message, testing::HasSubstr("--dictionary 9X9_1"));
}

}  // namespace
}  // namespace covis::app
