// SPDX-License-Identifier: Apache-2.0
#include "covis/features/rectification.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>

namespace covis {
namespace {

constexpr int kPlaceBits = 5, kPlaceSteps = 1 << kPlaceBits;  // steps of a place in a pixel

// Interpolates between four pixels: a left of b, below them c left of d.
uint8_t mix(int a, int b, int c, int d, int fraction) {
  const int fx = fraction & (kPlaceSteps - 1), fy = fraction >> kPlaceBits;
  const int above = kPlaceSteps * a + (b - a) * fx, below = kPlaceSteps * c + (d - c) * fx;
  const int sum = kPlaceSteps * above + (below - above) * fy;  // the weights add up to kPlaceSteps^2
  return static_cast<uint8_t>((sum + kPlaceSteps * kPlaceSteps / 2) >> (2 * kPlaceBits));
}

ResamplingMap make_map(const Camera& rectified, const Camera& from, const Eigen::Matrix3d& R_from_rectified) {
  ResamplingMap map(rectified.width, rectified.height, from.width, from.height);
  for (int v = 0; v < rectified.height; ++v) {
    for (int u = 0; u < rectified.width; ++u) {
      const auto pixel = from.project(R_from_rectified * rectified.pinhole.unproject(u, v));
      if (pixel) map.set(u, v, static_cast<float>(pixel->x()), static_cast<float>(pixel->y()));
    }
  }
  return map;
}

std::string size_text(const Camera& camera) {
  return std::to_string(camera.width) + "x" + std::to_string(camera.height);
}

}  // namespace

ResamplingMap::ResamplingMap(int width, int height, int from_width, int from_height)
    : width_(width),
      height_(height),
      from_width_(from_width),
      from_height_(from_height),
      places_(static_cast<size_t>(width) * static_cast<size_t>(height)) {
  assert(std::max({width, height, from_width, from_height}) <= kLargestSide);
}

void ResamplingMap::set(int u, int v, float x, float y) {
  Place& place = places_[static_cast<size_t>(v) * static_cast<size_t>(width_) + static_cast<size_t>(u)];
  place = {};
  constexpr float kFar = kPlaceSteps * kLargestSide;  // outside of every image
  x *= kPlaceSteps;
  y *= kPlaceSteps;
  if (!(std::abs(x) < kFar) || !(std::abs(y) < kFar)) return;
  const int ix = static_cast<int>(std::nearbyint(x)), iy = static_cast<int>(std::nearbyint(y));  // ties to even
  place.x = static_cast<int16_t>(ix >> kPlaceBits);
  place.y = static_cast<int16_t>(iy >> kPlaceBits);
  const bool inside = place.x >= 0 && place.y >= 0 && place.x + 1 < from_width_ && place.y + 1 < from_height_;
  const int fraction = (iy & (kPlaceSteps - 1)) * kPlaceSteps + (ix & (kPlaceSteps - 1));
  place.fraction = static_cast<uint16_t>(inside ? fraction : fraction + kBorder);
}

uint8_t ResamplingMap::at_border(ImageView<const uint8_t> from, Place place) {
  const auto at = [&](int x, int y) {
    return x >= 0 && y >= 0 && x < from.width && y < from.height ? from(x, y) : uint8_t{0};
  };
  const int x = place.x, y = place.y;
  return mix(at(x, y), at(x + 1, y), at(x, y + 1), at(x + 1, y + 1), place.fraction - kBorder);
}

void ResamplingMap::apply(ImageView<const uint8_t> from, ImageU8& to) const {
  assert(from.width == from_width_ && from.height == from_height_);
  to.resize(width_, height_);
  const Place* place = places_.data();
  for (int v = 0; v < height_; ++v) {
    uint8_t* row = to.row(v);
    for (int u = 0; u < width_; ++u, ++place) {
      if (place->fraction >= kBorder) {
        row[u] = at_border(from, *place);
        continue;
      }
      const uint8_t* above = from.row(place->y) + place->x;
      const uint8_t* below = above + from.stride;
      row[u] = mix(above[0], above[1], below[0], below[1], place->fraction);
    }
  }
}

Result<StereoRectification> StereoRectification::create(const Camera& left, const Camera& right, const SE3& T_rl) {
  if (left.width != right.width || left.height != right.height) {
    return fail("both images must have one size; the left is " + size_text(left) + ", the right " + size_text(right));
  }
  constexpr int kLargest = ResamplingMap::kLargestSide;
  if (left.width < 1 || left.height < 1 || left.width > kLargest || left.height > kLargest) {
    return fail("images must have 1 to " + std::to_string(kLargest) + " columns and rows; these are " +
                size_text(left));
  }
  const Eigen::Vector3d right_in_left = T_rl.centre();
  const double baseline = right_in_left.norm();
  if (!(baseline > 1e-4) || right_in_left.x() < 0.5 * baseline) {
    return fail("the right camera must lie to the right of the left one; its centre is at (" +
                std::to_string(right_in_left.x()) + ", " + std::to_string(right_in_left.y()) + ", " +
                std::to_string(right_in_left.z()) + ") m in the left camera");
  }
  if (!(T_rl.R()(2, 2) > 0)) {
    return fail("the cameras must look the same way; the right one's axis is turned by " +
                std::to_string(std::lround(std::acos(std::clamp(T_rl.R()(2, 2), -1.0, 1.0)) * 180 / std::numbers::pi)) +
                " degrees from the left one's");
  }
  // x points along the baseline, z as close as possible to the mean of both optical axes.
  const Eigen::Vector3d x = right_in_left / baseline;
  const Eigen::Vector3d axis = Eigen::Vector3d::UnitZ() + T_rl.R().transpose() * Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d y = axis.cross(x).normalized();
  Eigen::Matrix3d R_left_rectified;
  R_left_rectified << x, y, x.cross(y);

  StereoRectification result;
  result.T_left_rectified_ = SE3(R_left_rectified, Eigen::Vector3d::Zero());
  Camera& camera = result.camera_;
  camera.width = left.width;
  camera.height = left.height;
  const double f = (left.pinhole.fx + left.pinhole.fy + right.pinhole.fx + right.pinhole.fy) / 4;
  camera.pinhole = {f, f, left.width / 2.0, left.height / 2.0, f * baseline};
  const Eigen::Matrix3d R_right_rectified = T_rl.R() * R_left_rectified;
  // Shift the principal point by the mean offset of both image centres, so that both stay near the centre.
  Eigen::Vector2d shift = Eigen::Vector2d::Zero();
  int count = 0;
  for (const auto& [from, R] : {std::pair{&left, R_left_rectified}, std::pair{&right, R_right_rectified}}) {
    if (const auto ray = from->unproject({from->width / 2.0, from->height / 2.0})) {
      const Eigen::Vector3d in_rectified = R.transpose() * *ray;
      shift += camera.pinhole.project(in_rectified) - Eigen::Vector2d(camera.pinhole.cx, camera.pinhole.cy);
      ++count;
    }
  }
  if (count > 0) {
    camera.pinhole.cx -= shift.x() / count;
    camera.pinhole.cy -= shift.y() / count;
  }
  result.left_ = make_map(camera, left, R_left_rectified);
  result.right_ = make_map(camera, right, R_right_rectified);
  return result;
}

}  // namespace covis
