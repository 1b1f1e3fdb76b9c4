// SPDX-License-Identifier: Apache-2.0
// A camera from views of a board: OpenCV's calibration, with views that do not fit left out, and how sure it is.
#pragma once

#include <string>
#include <vector>

#include "apps/calibrate/board.h"
#include "covis/eval/plot.h"
#include "covis/geometry/camera.h"

namespace covis::app {

struct Residual {
  cv::Point2f pixel;
  cv::Point2f error;  // measured minus projected, pixels
};

struct Calibration {
  Camera camera;
  double rms = 0;                     // that of all residuals, pixels
  double fx_sigma = 0, cx_sigma = 0;  // standard deviations, pixels; 0 where they are not known (fisheye)
  size_t views = 0, left_out = 0;
  std::vector<Residual> residuals;
};

inline constexpr size_t kLeastViews = 6;

// lens: brown_conrady (k1 k2 p1 p2) or kannala_brandt. Error: fewer than kLeastViews views, or views that determine no
// camera: all of them from one direction, say.
Result<Calibration> calibrate(std::vector<BoardView> views, cv::Size image, Distortion lens);

// Each corner with its residual, drawn 50 times as long.
Plot residual_plot(const Calibration& calibration);

}  // namespace covis::app
