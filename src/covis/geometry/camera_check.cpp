// SPDX-License-Identifier: Apache-2.0
#include "covis/geometry/camera_check.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numbers>
#include <tuple>

namespace covis {
namespace {

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.7g", value);
  return text;
}

std::string out_of_bounds(const std::string& name, double value, double least, double most) {
  return name + ": " + number(value) + " is not right; it must be from " + number(least) + " to " + number(most);
}

// How far from the principal point, in pixels, the lens first shows two directions at one place: there points can't be
// undistorted. Infinite: nowhere.
double fold_of(const Camera& camera) {
  constexpr double kStep = 1e-3, kMost = 3;  // the angle's tangent; a fisheye's angle in radians
  const auto& k = camera.coefficients;
  const bool fisheye = camera.distortion == Distortion::kannala_brandt;
  double before = 0;
  for (double r = kStep; r < kMost; r += kStep) {
    const double s = r * r;
    const double factor =
        fisheye ? 1 + s * (k[0] + s * (k[1] + s * (k[2] + s * k[3]))) : 1 + s * (k[0] + s * (k[1] + s * k[4]));
    if (r * factor < before) return before * camera.pinhole.fx;
    before = r * factor;
  }
  return std::numeric_limits<double>::infinity();
}

}  // namespace

std::optional<std::string> problem_of(const Camera& camera) {
  using B = CameraBounds;
  const Pinhole& p = camera.pinhole;
  for (const auto& [name, value, least, most] :
       {std::tuple<const char*, double, double, double>{"width", camera.width, B::kLeastSide, B::kLargestSide},
        {"height", camera.height, B::kLeastSide, B::kLargestSide},
        {"fx, the focal length in pixels", p.fx, B::kLeastFocal, B::kLargestFocal},
        {"fy, the focal length in pixels", p.fy, B::kLeastFocal, B::kLargestFocal}}) {
    if (!(value >= least && value <= most)) return out_of_bounds(name, value, least, most);
  }
  if (!(p.cx > 0 && p.cx < camera.width && p.cy > 0 && p.cy < camera.height)) {
    return "the principal point (" + number(p.cx) + ", " + number(p.cy) + ") must lie inside the image of " +
           std::to_string(camera.width) + "x" + std::to_string(camera.height);
  }
  constexpr double kRounding = 1e-9;
  if (p.bf != 0 &&
      !(p.baseline() >= B::kLeastBaseline * (1 - kRounding) && p.baseline() <= B::kLargestBaseline * (1 + kRounding))) {
    return out_of_bounds("the baseline in metres", p.baseline(), B::kLeastBaseline, B::kLargestBaseline);
  }
  for (const double k : camera.coefficients) {
    if (!(std::abs(k) <= B::kLargestCoefficient))
      return out_of_bounds("a distortion coefficient", k, -B::kLargestCoefficient, B::kLargestCoefficient);
  }
  if (const double readout = p.row_time * camera.height; !(std::abs(readout) <= B::kLongestReadout * (1 + kRounding)))
    return out_of_bounds("the readout in seconds", readout, -B::kLongestReadout, B::kLongestReadout);
  return std::nullopt;
}

std::optional<std::string> problem_of_pair(const Pinhole& left, const Pinhole& right) {
  constexpr double kSame = 1e-3;  // share of the focal length
  for (const auto& [name, a, b] : {std::tuple{"fx", left.fx, right.fx},
                                   {"fy", left.fy, right.fy},
                                   {"cx", left.cx, right.cx},
                                   {"cy", left.cy, right.cy}}) {
    if (std::abs(a - b) <= kSame * left.fx) continue;
    return std::string(name) + " is " + number(a) + " left and " + number(b) +
           " right; both images of a rectified pair have the same";
  }
  return std::nullopt;
}

std::vector<std::string> doubts_about(const Camera& camera) {
  constexpr int kFewPixels = 64;
  constexpr double kMostStretched = 2;
  constexpr double kLeastFold = 0.25;                                                 // share of the shorter side
  constexpr double kDegrees = 180 / std::numbers::pi, kWidest = 160, kNarrowest = 2;  // degrees
  std::vector<std::string> doubts;
  if (std::min(camera.width, camera.height) < kFewPixels) {
    doubts.push_back("images of " + std::to_string(camera.width) + "x" + std::to_string(camera.height) +
                     " pixels show too little to be tracked; each side should have " + std::to_string(kFewPixels) +
                     " or more");
  }
  if (!(camera.pinhole.fx > 0 && camera.pinhole.fy > 0)) return doubts;
  const auto [shorter, longer] = std::minmax(camera.pinhole.fx, camera.pinhole.fy);
  if (longer > kMostStretched * shorter) {
    doubts.push_back("focal lengths of " + number(camera.pinhole.fx) + " (fx) and " + number(camera.pinhole.fy) +
                     " (fy) pixels mean that images are stretched by " + number(longer / shorter) +
                     "; fx and fy of a camera are about the same");
  }
  const double fold = camera.distortion == Distortion::none ? std::numeric_limits<double>::infinity() : fold_of(camera);
  if (fold < kLeastFold * std::min(camera.width, camera.height)) {
    doubts.push_back("a lens of this distortion shows two directions at one place, " + number(std::round(fold)) +
                     " pixels from the middle of the image and beyond; its coefficients can't be right");
  }
  if (camera.distortion == Distortion::kannala_brandt) return doubts;
  const double angle = 2 * std::atan(0.5 * camera.width / camera.pinhole.fx) * kDegrees;
  if (angle > kWidest || angle < kNarrowest) {
    doubts.push_back("a focal length of " + number(camera.pinhole.fx) + " pixels means that images " +
                     std::to_string(camera.width) + " pixels wide show " + number(angle) +
                     " degrees, which no such camera does");
  }
  return doubts;
}

}  // namespace covis
