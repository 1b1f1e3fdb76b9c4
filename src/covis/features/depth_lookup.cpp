// SPDX-License-Identifier: Apache-2.0
#include "covis/features/depth_lookup.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace covis {
namespace {

// Distance, in pixels of the level, at which the depth is compared on both sides. Of 2, 3 and 4 it separates correct
// depths from wrong ones best.
constexpr float kReach = 2;
// Largest relative second difference of the inverse depth over twice that distance. It is 0 over a plane; the noise of
// a depth camera at 3 m makes it 1 to 2 percent.
constexpr float kMaxBend = 0.04f;

// The depth between four pixels, or `nearest` unless all of them show the surface of that one.
float between_pixels(ImageView<const float> depth, float x, float y, float nearest) {
  const int x0 = static_cast<int>(std::floor(x)), y0 = static_cast<int>(std::floor(y));
  if (x0 < 0 || y0 < 0 || x0 + 1 >= depth.width || y0 + 1 >= depth.height) return nearest;
  const float fx = x - static_cast<float>(x0), fy = y - static_cast<float>(y0);
  const std::array<float, 4> share = {(1 - fx) * (1 - fy), fx * (1 - fy), (1 - fx) * fy, fx * fy};
  const std::array<float, 4> z = {depth(x0, y0), depth(x0 + 1, y0), depth(x0, y0 + 1), depth(x0 + 1, y0 + 1)};
  float inverse = 0;
  for (size_t k = 0; k < z.size(); ++k) {
    if (!(std::abs(z[k] - nearest) <= kMaxBend * nearest)) return nearest;
    inverse += share[k] / z[k];
  }
  return 1 / inverse;
}

}  // namespace

float depth_at(ImageView<const float> depth, float at_x, float at_y, float scale) {
  const int x = static_cast<int>(std::lround(at_x)), y = static_cast<int>(std::lround(at_y));
  const float z = depth(x, y);
  if (!is_depth(z)) return 0;
  const int straight = std::max(1, static_cast<int>(std::lround(kReach * scale)));
  const int diagonal = std::max(1, static_cast<int>(std::lround(kReach * scale * std::sqrt(0.5f))));
  const std::array<std::array<int, 2>, 4> steps = {
      {{straight, 0}, {0, straight}, {diagonal, diagonal}, {diagonal, -diagonal}}};
  for (const auto& [dx, dy] : steps) {
    if (x < dx || x + dx >= depth.width || y < std::abs(dy) || y + std::abs(dy) >= depth.height) continue;
    const float a = depth(x - dx, y - dy), b = depth(x + dx, y + dy);
    // Holds when 1 / a + 1 / b > (2 + kMaxBend) / z; false when a or b is NaN or infinite.
    if (a > 0 && b > 0 && (a + b) * z > (2 + kMaxBend) * a * b) return 0;
  }
  return between_pixels(depth, at_x, at_y, z);
}

float depth_at(ImageView<const float> depth, const DepthRegistration& registration, const Eigen::Vector2d& centre,
               float x, float y, float scale) {
  constexpr float kSettled = 0.05f;  // as a share: what is left of the parallax is less than a pixel
  constexpr int kSteps = 4;
  float z = 0;
  for (int k = 0; k < kSteps; ++k) {
    const Eigen::Vector2f at =
        registration.pixel(Eigen::Vector2d(x, y), centre, z > 0 ? 1 / static_cast<double>(z) : 0).cast<float>();
    const int column = static_cast<int>(std::lround(at.x())), row = static_cast<int>(std::lround(at.y()));
    if (column < 0 || row < 0 || column >= depth.width || row >= depth.height) return 0;
    const float there = depth(column, row);
    if (!is_depth(there)) return 0;
    if (std::abs(there - z) <= kSettled * z) return depth_at(depth, at.x(), at.y(), scale);
    z = there;
  }
  return 0;
}

}  // namespace covis
