// SPDX-License-Identifier: Apache-2.0
#include "covis/geometry/depth_registration.h"

#include <array>
#include <cmath>
#include <cstdio>

namespace covis {

bool DepthRegistration::valid() const {
  constexpr double kMostScale = 10, kMostPixels = 1e5;
  const auto within = [](double pixels) { return std::abs(pixels) <= kMostPixels; };  // false for what is not a number
  return scale >= 1 / kMostScale && scale <= kMostScale && within(shift_x) && within(shift_y) && within(parallax_x) &&
         within(parallax_y);
}

DepthRegistration registration_of(const DepthCamera& depth, double fx, double cx, double cy) {
  return {depth.fx / fx, depth.cx - cx, depth.cy - cy, 0 - depth.fx * depth.x, 0 - depth.fx * depth.y};
}

DepthCamera depth_camera_of(const DepthRegistration& r, double fx, double cx, double cy) {
  const double focal = r.scale * fx;
  return {focal, cx + r.shift_x, cy + r.shift_y, 0 - r.parallax_x / focal, 0 - r.parallax_y / focal};
}

std::string description(const DepthRegistration& r) {
  std::array<char, 200> text{};
  std::snprintf(text.data(), text.size(),
                "%.4f times as large, moved by %.1f and %.1f pixels, and by %.1f and %.1f at a metre", r.scale,
                r.shift_x, r.shift_y, r.parallax_x, r.parallax_y);
  return text.data();
}

}  // namespace covis
