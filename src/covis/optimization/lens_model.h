// SPDX-License-Identifier: Apache-2.0
// The image of a point by a lens that is adjusted (lens_adjustment.h). Source: Brown, "Close-range camera calibration",
// 1971: two radial and the two tangential coefficients.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "covis/geometry/measurement.h"

namespace covis {

// The parameters of a camera that are adjusted, or their standard deviations: that of the focal length is a share of
// it.
struct Lens {
  double focal = 0;       // pixels
  double k1 = 0, k2 = 0;  // coefficients of Brown's model: radii in focal lengths
  double cx = 0, cy = 0;  // how far the principal point is off where the problem's camera has it, pixels
  double p1 = 0, p2 = 0;  // tangential coefficients of Brown's model
};

inline constexpr int kLensParameters = 7;  // the focal length is adjusted by its logarithm
using LensVector = Eigen::Matrix<double, kLensParameters, 1>;
using LensMatrix = Eigen::Matrix<double, kLensParameters, kLensParameters>;

inline LensVector vector_of(const Lens& lens) {
  return (LensVector() << lens.focal, lens.k1, lens.k2, lens.cx, lens.cy, lens.p1, lens.p2).finished();
}
inline Lens lens_of(const LensVector& v) { return {v(0), v(1), v(2), v(3), v(4), v(5), v(6)}; }

// An image of a point, pixels from where the problem's camera has its principal point, and how it moves.
struct LensImage {
  Eigen::Vector2d pixel;
  Eigen::Matrix<double, 2, 3> by_point;  // with the point in the camera
  Eigen::Matrix<double, 2, kLensParameters> by_lens;
};

// The pixel at which the lens shows the point p_c in the camera, metres; no derivatives. nullopt: it is behind the
// camera, or the lens would fold the image over itself there.
inline std::optional<Eigen::Vector2d> lens_pixel(const Eigen::Vector3d& p_c, const Lens& lens) {
  if (!(p_c.z() > kMinDepth)) return std::nullopt;
  const Eigen::Vector2d at = p_c.head<2>() / p_c.z();
  const double x = at.x(), y = at.y(), r2 = at.squaredNorm();
  if (!(1 + (3 * lens.k1 + 5 * lens.k2 * r2) * r2 > 0)) return std::nullopt;
  const Eigen::Vector2d tangential(2 * lens.p1 * x * y + lens.p2 * (r2 + 2 * x * x),
                                   2 * lens.p2 * x * y + lens.p1 * (r2 + 2 * y * y));
  return Eigen::Vector2d(lens.focal * ((1 + (lens.k1 + lens.k2 * r2) * r2) * at + tangential) +
                         Eigen::Vector2d(lens.cx, lens.cy));
}

// The same with its derivatives.
inline std::optional<LensImage> lens_image(const Eigen::Vector3d& p_c, const Lens& lens) {
  const auto pixel = lens_pixel(p_c, lens);
  if (!pixel) return std::nullopt;
  LensImage image{.pixel = *pixel, .by_point = {}, .by_lens = {}};
  const auto& [focal, k1, k2, cx, cy, p1, p2] = lens;
  const Eigen::Vector2d at = p_c.head<2>() / p_c.z();
  const double x = at.x(), y = at.y(), r2 = at.squaredNorm(), d = 1 + (k1 + k2 * r2) * r2;
  Eigen::Matrix<double, 2, 3> ray;  // d at / d p_c
  ray << 1, 0, -x, 0, 1, -y;
  ray /= p_c.z();
  Eigen::Matrix2d bend = d * Eigen::Matrix2d::Identity() + 2 * (k1 + 2 * k2 * r2) * at * at.transpose();
  const double across = 2 * (p1 * x + p2 * y);
  bend += Eigen::Matrix2d{{2 * p1 * y + 6 * p2 * x, across}, {across, 6 * p1 * y + 2 * p2 * x}};
  image.by_point = focal * bend * ray;
  image.by_lens.col(0) = *pixel - Eigen::Vector2d(cx, cy);
  image.by_lens.col(1) = focal * r2 * at;
  image.by_lens.col(2) = focal * r2 * r2 * at;
  image.by_lens.middleCols<2>(3).setIdentity();
  image.by_lens.col(5) = focal * Eigen::Vector2d(2 * x * y, r2 + 2 * y * y);
  image.by_lens.col(6) = focal * Eigen::Vector2d(r2 + 2 * x * x, 2 * x * y);
  return image;
}

}  // namespace covis
