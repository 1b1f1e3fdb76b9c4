// SPDX-License-Identifier: Apache-2.0
// Cameras. Keypoints are undistorted when features are made, into the pinhole model `Pinhole` of the same camera; all
// later stages use Pinhole only. A distortion that is found later is taken out of them too (features/straightening.h).
// Pixel centres lie at integer coordinates; x right, y down, z forward. Sources: Brown, "Close-range camera
// calibration", 1971; Kannala and Brandt, "A generic camera model and calibration method for conventional, wide-angle,
// and fish-eye lenses", PAMI 2006, eq. 6 with odd powers to theta^9.
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <string>

#include "covis/geometry/depth_noise.h"
#include "covis/geometry/depth_registration.h"
#include "covis/geometry/shift_field.h"

namespace covis {

// Distortion that the undistorted pixels of a camera still have, because its lens model was none or not quite right:
// the first two radial coefficients of Brown's model, with radii in focal lengths.
struct ResidualDistortion {
  double k1 = 0, k2 = 0;
  bool any() const { return k1 != 0 || k2 != 0; }
  // The image of a ray at this squared radius lies farther out than those of rays within: it is not folded over them.
  bool unfolds(double r2) const { return 1 + (3 * k1 + 5 * k2 * r2) * r2 > 0; }
  friend bool operator==(const ResidualDistortion&, const ResidualDistortion&) = default;
};

// Intrinsics of an ideal camera, and the stereo baseline (0 when monocular): bf = fx * baseline, pixels * metres.
struct Pinhole {
  double fx = 0, fy = 0, cx = 0, cy = 0;  // pixels
  double bf = 0;                          // fx times the (real or virtual) baseline in metres; 0: no stereo or depth
  DepthNoise depth_noise{};               // RGB-D; not known: depth is measured as a disparity between two images
  ResidualDistortion residual{};          // as a run found it, and took it out of all keypoints
  DepthRegistration registration{};       // RGB-D: as given or as a run found it
  // Rolling shutter: seconds from the exposure of one row to that of the next, as given or as a run found it; 0: all
  // rows at once. Negative: the last row comes first, as in a camera that is mounted upside down.
  double row_time = 0;
  // Stereo: how far right of its place the right image shows what it shows, which a run found and took out of all
  // disparities. Its place is that column of the right image, in the row of the left one.
  ShiftField right_columns{};

  double baseline() const { return bf / fx; }
  // As if it measured none, where depths are in another unit than the map's.
  Pinhole without_depth() const {
    return {.fx = fx, .fy = fy, .cx = cx, .cy = cy, .residual = residual, .row_time = row_time};
  }
  Eigen::Vector2d project(const Eigen::Vector3d& p_c) const {
    return {fx * p_c.x() / p_c.z() + cx, fy * p_c.y() / p_c.z() + cy};
  }
  // Returns the ray through a pixel, with z = 1.
  Eigen::Vector3d unproject(double u, double v) const { return {(u - cx) / fx, (v - cy) / fy, 1.0}; }
  // The column of a rectified right image for one that was measured in a row.
  double rectified_column(double u_right, double v) const {
    return u_right - right_columns.at((u_right - cx) / fx, (v - cy) / fy);
  }
  // From an undistorted pixel of the camera as it was given to that without the residual distortion, and back. nullopt:
  // no ray shows so far out.
  std::optional<Eigen::Vector2d> straightened(const Eigen::Vector2d& pixel) const;
  Eigen::Vector2d bent(const Eigen::Vector2d& pixel) const;
  friend bool operator==(const Pinhole&, const Pinhole&) = default;
};

// The same distortion and columns were found and taken out of keypoints and disparities.
inline bool same_corrections(const Pinhole& a, const Pinhole& b) {
  return a.residual == b.residual && a.right_columns == b.right_columns;
}

// The baseline that an RGB-D camera has where none is given, metres: a unit for its depths as disparities. No result
// depends on it.
inline constexpr double kVirtualBaseline = 0.08;

// Up to where a measured depth is close, so that it tells scale and translation: stereo in baselines, a depth sensor by
// the noise of its depth.
struct CloseDepth {
  double baselines = 40;
  double noise = 0.02;  // sigma of a depth as a share of it

  double metres(const Pinhole& camera) const {
    return camera.depth_noise.known() ? camera.depth_noise.reach(noise) : baselines * camera.baseline();
  }
};

enum class Distortion { none, brown_conrady, kannala_brandt };

// One physical camera: image size, intrinsics, lens. It is one class with a switch rather than a hierarchy because it
// is a copyable value and the set of lens models is closed.
struct Camera {
  int width = 0, height = 0;  // pixels
  Pinhole pinhole;            // intrinsics of the image and, by definition, of the undistorted keypoints
  Distortion distortion = Distortion::none;
  std::array<double, 5> coefficients{};  // brown_conrady: k1 k2 p1 p2 k3; kannala_brandt: k1 k2 k3 k4

  friend bool operator==(const Camera&, const Camera&) = default;
  // Maps a point in camera coordinates to a (distorted) pixel. Returns nullopt when this lens cannot see the point (z
  // <= 0 for pinhole kinds). J: the 2x3 Jacobian d pixel / d point.
  std::optional<Eigen::Vector2d> project(const Eigen::Vector3d& p_c, Eigen::Matrix<double, 2, 3>* J = nullptr) const;
  // Maps a (distorted) pixel to its unit ray. Returns nullopt when the inverse does not exist or does not converge.
  std::optional<Eigen::Vector3d> unproject(const Eigen::Vector2d& pixel) const;
  // Maps a (distorted) pixel to that of the ideal pinhole camera. Returns nullopt for rays at 90 degrees and beyond.
  std::optional<Eigen::Vector2d> undistort(const Eigen::Vector2d& pixel) const;
};

// A camera as it was given, and the model of its undistorted pixels as it was refined. Without what is of depth.
struct RefinedCamera {
  Camera given;
  Pinhole pinhole;
  friend bool operator==(const RefinedCamera&, const RefinedCamera&) = default;
};

// The pixel of a given camera's image that shows a point in camera coordinates, with its focal length and residual
// distortion as they were refined. nullopt: none does.
std::optional<Eigen::Vector2d> image_pixel(const Camera& given, const Pinhole& refined, const Eigen::Vector3d& p_c);

// Lists as text how `other` differs from `camera` by more than the rounding of a file ("fx 718.9 instead of 707.1, …");
// empty when they agree.
std::string difference(const Camera& camera, const Camera& other);

// They agree in all but what measures depth.
bool same_lens(const Camera& camera, const Camera& other);

}  // namespace covis
