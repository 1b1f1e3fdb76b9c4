// SPDX-License-Identifier: Apache-2.0
#include "apps/calibrate/charuco.h"

#include <algorithm>
#ifdef COVIS_CHARUCO
#include <opencv2/aruco/charuco.hpp>
#endif
#include <vector>

namespace covis::app {

#ifdef COVIS_CHARUCO
namespace {

constexpr size_t kLeastCorners = 8;  // that a board must show

class OpenCvFinder : public CharucoFinder {
 public:
  explicit OpenCvFinder(const Board& board)
      : dictionary_(cv::aruco::getPredefinedDictionary(board.dictionary)),
        board_(cv::aruco::CharucoBoard::create(board.columns, board.rows, static_cast<float>(board.square),
                                               static_cast<float>(board.marker), dictionary_)) {}

  std::optional<BoardView> find(const cv::Mat& grey) const override {
    std::vector<int> markers, ids;
    std::vector<std::vector<cv::Point2f>> outlines;
    cv::aruco::detectMarkers(grey, dictionary_, outlines, markers);
    if (markers.empty()) return std::nullopt;
    BoardView view;
    cv::aruco::interpolateCornersCharuco(outlines, markers, grey, board_, view.pixels, ids);
    if (ids.size() < kLeastCorners) return std::nullopt;
    for (const int id : ids) view.corners.push_back(board_->chessboardCorners[static_cast<size_t>(id)]);
    // Corners of a single line leave the view open.
    const auto differ = [&](auto coordinate) {
      return std::any_of(view.corners.begin(), view.corners.end(),
                         [&](const cv::Point3f& p) { return p.*coordinate != view.corners.front().*coordinate; });
    };
    if (!differ(&cv::Point3f::x) || !differ(&cv::Point3f::y)) return std::nullopt;
    return view;
  }

 private:
  cv::Ptr<cv::aruco::Dictionary> dictionary_;
  cv::Ptr<cv::aruco::CharucoBoard> board_;
};

}  // namespace

std::unique_ptr<CharucoFinder> make_charuco_finder(const Board& board) { return std::make_unique<OpenCvFinder>(board); }

Result<void> charuco_is_there() { return {}; }

#else

std::unique_ptr<CharucoFinder> make_charuco_finder(const Board&) { return nullptr; }

Result<void> charuco_is_there() {
  return fail(
      "--charuco: this Covis was built without OpenCV's module aruco. Install libopencv-contrib-dev (tools/setup "
      "--charuco does) and build Covis again with -DCOVIS_CHARUCO=ON");
}

#endif

}  // namespace covis::app
