// SPDX-License-Identifier: Apache-2.0
// Calibration boards, and where they are in an image (OpenCV's detectors).
#pragma once

#include <cstdint>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "covis/core/error.h"

namespace covis::app {

struct Board {
  enum class Kind { checkerboard, charuco };
  Kind kind = Kind::checkerboard;
  // checkerboard: inner corners, one fewer than the squares in a row and in a column; charuco: squares.
  int columns = 9, rows = 6;
  double square = 0;   // side of a square, metres
  double marker = 0;   // charuco: side of a marker, metres
  int dictionary = 0;  // charuco: OpenCV's number of the dictionary of markers
};

// A board in one image.
struct BoardView {
  int64_t frame = 0;
  std::vector<cv::Point3f> corners;  // on the board, metres, z = 0
  std::vector<cv::Point2f> pixels;   // pixel of each corner
};

class CharucoFinder;

class BoardFinder {
 public:
  explicit BoardFinder(const Board& board);
  ~BoardFinder();

  // The corners of the board in a grey image; nothing when it is not seen: a checkerboard as a whole, of a ChArUco
  // board at least eight corners.
  std::optional<BoardView> find(const cv::Mat& grey) const;

 private:
  const Board board_;
  std::unique_ptr<CharucoFinder> charuco_;
};

// The number of a dictionary by its name in OpenCV, without DICT_: "4X4_50", "5X5_100", "6X6_250" and so on.
Result<int> dictionary_of(const std::string& name);

// Chooses views that differ in place, size or tilt, in their order, at most `most`: a video has hundreds that are
// alike.
std::vector<BoardView> choose_views(const std::vector<BoardView>& views, cv::Size image, size_t most);

}  // namespace covis::app
