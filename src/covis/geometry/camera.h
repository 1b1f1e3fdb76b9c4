// SPDX-License-Identifier: Apache-2.0
// Cameras. Keypoints are undistorted once, when features are made, into the pinhole `Pinhole` of the same camera;
// everything after the features knows Pinhole only. Pixel centres at whole numbers; x right, y down, z forward.
// Sources: Brown, "Close-range camera calibration", 1971; Kannala and Brandt, "A generic camera model and calibration
// method for conventional, wide-angle, and fish-eye lenses", PAMI 2006, eq. 6 with odd powers to theta^9.
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <string>

namespace covis {

// Intrinsics of an ideal camera, and the stereo baseline (0 when monocular): bf = fx * baseline, pixels * metres.
struct Pinhole {
  double fx = 0, fy = 0, cx = 0, cy = 0;  // pixels
  double bf = 0;                          // fx times the (real or virtual) baseline in metres; 0: no depth sensor

  double baseline() const { return bf / fx; }
  Eigen::Vector2d project(const Eigen::Vector3d& p_c) const {
    return {fx * p_c.x() / p_c.z() + cx, fy * p_c.y() / p_c.z() + cy};
  }
  // The ray through a pixel, with z = 1.
  Eigen::Vector3d unproject(double u, double v) const { return {(u - cx) / fx, (v - cy) / fy, 1.0}; }
  friend bool operator==(const Pinhole&, const Pinhole&) = default;
};

enum class Distortion { none, brown_conrady, kannala_brandt };

// One physical camera: image size, intrinsics, lens. One class with a switch rather than a hierarchy: it is a value,
// copied freely, and the set of lenses is closed.
struct Camera {
  int width = 0, height = 0;  // pixels
  Pinhole pinhole;            // intrinsics of the image and, by definition, of the undistorted keypoints
  Distortion distortion = Distortion::none;
  std::array<double, 5> coefficients{};  // brown_conrady: k1 k2 p1 p2 k3; kannala_brandt: k1 k2 k3 k4

  // Point in camera coordinates to (distorted) pixel; nothing when it can't be seen by this lens (z <= 0 for pinhole
  // kinds). With J: the 2x3 Jacobian d pixel / d point.
  std::optional<Eigen::Vector2d> project(const Eigen::Vector3d& p_c, Eigen::Matrix<double, 2, 3>* J = nullptr) const;
  // (Distorted) pixel to the unit ray it sees; nothing when the inverse does not exist or does not converge.
  std::optional<Eigen::Vector3d> unproject(const Eigen::Vector2d& pixel) const;
  // (Distorted) pixel to where the ideal pinhole would see it; nothing for rays at 90 degrees and beyond.
  std::optional<Eigen::Vector2d> undistort(const Eigen::Vector2d& pixel) const;
};

// The figures of `other` that differ from those of `camera` by more than the digits of a file, as text ("fx 718.9
// instead of 707.1, …"); empty when nothing does.
std::string difference(const Camera& camera, const Camera& other);

}  // namespace covis
