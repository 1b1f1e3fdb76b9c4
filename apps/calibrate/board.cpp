// SPDX-License-Identifier: Apache-2.0
#include "apps/calibrate/board.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#include <string>

#include "apps/calibrate/charuco.h"

namespace covis::app {
namespace {

std::vector<cv::Point3f> checkerboard_corners(const Board& board) {
  std::vector<cv::Point3f> corners;
  for (int y = 0; y < board.rows; ++y) {
    for (int x = 0; x < board.columns; ++x)
      corners.emplace_back(static_cast<float>(x * board.square), static_cast<float>(y * board.square), 0.0f);
  }
  return corners;
}

std::optional<BoardView> find_checkerboard(const Board& board, const cv::Mat& grey) {
  BoardView view;
  const cv::Size size(board.columns, board.rows);
  if (!cv::findChessboardCorners(grey, size, view.pixels,
                                 cv::CALIB_CB_ADAPTIVE_THRESH | cv::CALIB_CB_NORMALIZE_IMAGE | cv::CALIB_CB_FAST_CHECK))
    return std::nullopt;
  // The window must not reach the next corner.
  const double side = cv::norm(view.pixels[1] - view.pixels[0]);
  const int half = std::clamp(static_cast<int>(side / 4), 2, 11);
  const cv::TermCriteria until(cv::TermCriteria::EPS | cv::TermCriteria::COUNT, 30, 0.001);
  cv::cornerSubPix(grey, view.pixels, {half, half}, {-1, -1}, until);
  view.corners = checkerboard_corners(board);
  return view;
}

// Tells one view from another: the board's centre, its size and how much its sides shrink, as shares of the image.
std::array<double, 5> pose_of(const BoardView& view, cv::Size image) {
  const cv::Rect2f box = cv::boundingRect(view.pixels);
  cv::Mat homography = cv::findHomography(view.corners, view.pixels);
  if (homography.empty()) homography = cv::Mat::eye(3, 3, CV_64F);
  const double w = image.width, h = image.height;
  const double reach = cv::norm(view.corners.back() - view.corners.front());
  // The last row of the homography is the tilt.
  return {(box.x + box.width / 2) / w, (box.y + box.height / 2) / h, std::sqrt(box.area() / (w * h)),
          homography.at<double>(2, 0) * reach, homography.at<double>(2, 1) * reach};
}

}  // namespace

BoardFinder::BoardFinder(const Board& board) : board_(board) {
  if (board.kind == Board::Kind::charuco) charuco_ = make_charuco_finder(board);
}

BoardFinder::~BoardFinder() = default;

std::optional<BoardView> BoardFinder::find(const cv::Mat& grey) const {
  if (board_.kind == Board::Kind::checkerboard) return find_checkerboard(board_, grey);
  return charuco_ ? charuco_->find(grey) : std::nullopt;
}

Result<int> dictionary_of(const std::string& name) {
  std::map<std::string, int> known;
  const char* const sizes[] = {"4X4", "5X5", "6X6", "7X7"};
  const char* const counts[] = {"50", "100", "250", "1000"};
  // OpenCV numbers them in this order.
  for (int s = 0; s < 4; ++s) {
    for (int c = 0; c < 4; ++c) known.emplace(std::string(sizes[s]) + "_" + counts[c], 4 * s + c);
  }
  const auto found = known.find(name);
  if (found == known.end())
    return fail("--dictionary " + name + ": it is none of 4X4, 5X5, 6X6, 7X7 with _50, _100, _250 or _1000");
  return found->second;
}

std::vector<BoardView> choose_views(const std::vector<BoardView>& views, cv::Size image, size_t most) {
  std::vector<BoardView> chosen;
  // The difference asked for is as great as leaves enough of them.
  for (double apart = 0.02; chosen.empty() || chosen.size() > most; apart *= 1.5) {
    chosen.clear();
    std::vector<std::array<double, 5>> poses;
    for (const BoardView& view : views) {
      const auto pose = pose_of(view, image);
      const bool is_new = std::all_of(poses.begin(), poses.end(), [&](const auto& other) {
        double difference = 0;
        for (size_t i = 0; i < pose.size(); ++i) difference = std::max(difference, std::abs(pose[i] - other[i]));
        return difference > apart;
      });
      if (!is_new) continue;
      poses.push_back(pose);
      chosen.push_back(view);
    }
    if (views.empty()) break;
  }
  return chosen;
}

}  // namespace covis::app
