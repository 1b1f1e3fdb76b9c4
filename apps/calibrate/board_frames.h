// SPDX-License-Identifier: Apache-2.0
// The views of a board in a video or in a folder of images.
#pragma once

#include <atomic>
#include <string>
#include <vector>

#include "apps/calibrate/board.h"
#include "covis/core/error.h"

namespace covis::app {

struct BoardFrames {
  std::vector<BoardView> views;
  cv::Size image;
  int frames = 0;  // number of images that were looked at
};

// stride: only every n-th image is looked at; 0: every fifth of a video, whose next image shows the same, and each of a
// folder. Ends early when `stop` is not zero. Images that can't be read are passed over with a warning. Errors name the
// path: neither video nor folder, no images, images of two sizes.
Result<BoardFrames> look_for_board(const std::string& path, const BoardFinder& finder, int stride,
                                   const std::atomic<int>& stop);

}  // namespace covis::app
