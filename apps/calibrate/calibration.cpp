// SPDX-License-Identifier: Apache-2.0
#include "apps/calibrate/calibration.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <opencv2/calib3d.hpp>

#include "covis/core/quantile.h"

namespace covis::app {
namespace {

// A camera, and where its board was in each view.
struct Solved {
  cv::Mat K = cv::Mat::eye(3, 3, CV_64F), lens, sigmas;
  std::vector<cv::Mat> rotations, translations;
};

struct Lists {
  std::vector<std::vector<cv::Point3f>> corners;
  std::vector<std::vector<cv::Point2f>> pixels;
  explicit Lists(const std::vector<BoardView>& views) {
    for (const BoardView& view : views) {
      corners.push_back(view.corners);
      pixels.push_back(view.pixels);
    }
  }
};

Solved solve(const std::vector<BoardView>& views, cv::Size image, Distortion lens) {
  const Lists lists(views);
  Solved s;
  if (lens == Distortion::kannala_brandt) {
    cv::fisheye::calibrate(lists.corners, lists.pixels, image, s.K, s.lens, s.rotations, s.translations,
                           cv::fisheye::CALIB_RECOMPUTE_EXTRINSIC | cv::fisheye::CALIB_FIX_SKEW);
  } else {
    cv::calibrateCamera(lists.corners, lists.pixels, image, s.K, s.lens, s.rotations, s.translations, s.sigmas,
                        cv::noArray(), cv::noArray(), cv::CALIB_FIX_K3);
  }
  return s;
}

std::vector<Residual> residuals_of(const BoardView& view, const Solved& s, size_t index, Distortion lens) {
  std::vector<cv::Point2f> projected;
  if (lens == Distortion::kannala_brandt) {
    cv::fisheye::projectPoints(view.corners, projected, s.rotations[index], s.translations[index], s.K, s.lens);
  } else {
    cv::projectPoints(view.corners, s.rotations[index], s.translations[index], s.K, s.lens, projected);
  }
  std::vector<Residual> residuals;
  for (size_t i = 0; i < projected.size(); ++i) residuals.push_back({view.pixels[i], view.pixels[i] - projected[i]});
  return residuals;
}

double rms_of(const std::vector<Residual>& residuals) {
  double sum = 0;
  for (const Residual& r : residuals) sum += static_cast<double>(r.error.dot(r.error));
  return std::sqrt(sum / static_cast<double>(residuals.size()));
}

// Removes views whose error is more than three times the median one: a corner was taken for another, or the image was
// blurred. Returns how many.
size_t leave_out_misfits(const Solved& s, Distortion lens, std::vector<BoardView>& views) {
  std::vector<double> errors;
  for (size_t i = 0; i < views.size(); ++i) errors.push_back(rms_of(residuals_of(views[i], s, i, lens)));
  const double limit = 3 * quantile(errors, 0.5);
  std::vector<BoardView> kept;
  for (size_t i = 0; i < views.size(); ++i) {
    if (errors[i] <= limit) kept.push_back(std::move(views[i]));
  }
  const size_t removed = errors.size() - kept.size();
  views = std::move(kept);
  return removed;
}

Camera camera_of(const Solved& s, cv::Size image, Distortion lens) {
  Camera camera;
  camera.width = image.width;
  camera.height = image.height;
  camera.pinhole = {s.K.at<double>(0, 0), s.K.at<double>(1, 1), s.K.at<double>(0, 2), s.K.at<double>(1, 2), 0};
  camera.distortion = lens;
  for (size_t i = 0; i < std::min(camera.coefficients.size(), s.lens.total()); ++i)
    camera.coefficients[i] = s.lens.at<double>(static_cast<int>(i));
  return camera;
}

std::string problem_of(const Calibration& c) {
  const Pinhole& p = c.camera.pinhole;
  const double size = std::max(c.camera.width, c.camera.height);
  if (!(p.fx > 0.1 * size && p.fx < 20 * size && p.fy > 0.1 * size && p.fy < 20 * size) ||
      !(p.cx > 0 && p.cx < c.camera.width && p.cy > 0 && p.cy < c.camera.height) || !std::isfinite(c.rms))
    return "the views determine no camera: show the board tilted, near and far, and in all corners of the image";
  return {};
}

}  // namespace

Result<Calibration> calibrate(std::vector<BoardView> views, cv::Size image, Distortion lens) {
  Calibration result;
  Solved solved;
  try {
    for (int round = 0; round < 2; ++round) {
      if (views.size() < kLeastViews) {
        return fail("the board was found in " + std::to_string(views.size()) + " different views that fit; " +
                    std::to_string(kLeastViews) +
                    " at least are needed (of a checkerboard --board counts the inner corners)");
      }
      solved = solve(views, image, lens);
      if (round == 0) result.left_out = leave_out_misfits(solved, lens, views);
      if (result.left_out == 0) break;
    }
  } catch (const cv::Exception& error) {
    return fail("the views determine no camera: " + error.err);
  }
  result.camera = camera_of(solved, image, lens);
  result.views = views.size();
  for (size_t i = 0; i < views.size(); ++i) {
    const auto residuals = residuals_of(views[i], solved, i, lens);
    result.residuals.insert(result.residuals.end(), residuals.begin(), residuals.end());
  }
  result.rms = rms_of(result.residuals);
  if (!solved.sigmas.empty()) {
    result.fx_sigma = solved.sigmas.at<double>(0);
    result.cx_sigma = solved.sigmas.at<double>(2);
  }
  if (const std::string problem = problem_of(result); !problem.empty()) return fail(problem);
  return result;
}

Plot residual_plot(const Calibration& c) {
  constexpr double kLonger = 50;
  PlotSeries corners{
      .label = "corners", .x = {}, .y = {}, .colour = {120, 130, 145}, .style = PlotSeries::Style::dots, .width = 1.5};
  PlotSeries errors{.label = "residuals, 50 times as long", .x = {}, .y = {}, .colour = {200, 40, 30}};
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const Residual& r : c.residuals) {
    const double x = r.pixel.x, y = c.camera.height - r.pixel.y;  // plots have y upwards
    corners.x.push_back(x);
    corners.y.push_back(y);
    for (const double v : {x, x + kLonger * r.error.x, nan}) errors.x.push_back(v);
    for (const double v : {y, y - kLonger * r.error.y, nan}) errors.y.push_back(v);
  }
  char title[80];
  std::snprintf(title, sizeof title, "%zu views, rms %.2f pixels", c.views, c.rms);
  Plot plot;
  plot.title = title;
  plot.x_label = "column [pixels]";
  plot.y_label = "pixels above the image's lower edge";
  plot.series = {std::move(corners), std::move(errors)};
  plot.equal_aspect = true;
  plot.height = 800;
  plot.x_range = {0, static_cast<double>(c.camera.width)};
  plot.y_range = {0, static_cast<double>(c.camera.height)};
  return plot;
}

}  // namespace covis::app
