// SPDX-License-Identifier: Apache-2.0
// ChArUco boards, by OpenCV's module aruco, which a Covis without it does not find (COVIS_CHARUCO).
#pragma once

#include <memory>
#include <opencv2/core.hpp>
#include <optional>

#include "apps/calibrate/board.h"
#include "covis/core/error.h"

namespace covis::app {

class CharucoFinder {
 public:
  virtual ~CharucoFinder() = default;
  // Returns the corners that a grey image shows, if there are enough of them.
  virtual std::optional<BoardView> find(const cv::Mat& grey) const = 0;
};

std::unique_ptr<CharucoFinder> make_charuco_finder(const Board& board);
// An error in a Covis that was built without them.
Result<void> charuco_is_there();

}  // namespace covis::app
