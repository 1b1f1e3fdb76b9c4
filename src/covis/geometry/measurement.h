// SPDX-License-Identifier: Apache-2.0
// The measurement of a point by a camera: z = h(p_c) = (u, v, bf / depth); the third row, the disparity, exists only
// with a stereo or depth sensor and has a variance of its own. Searches, checks and solvers all call this h, so that
// another camera model needs changes in one place only. (The pose optimisation alone repeats it, in the order of
// operations that is fastest.) Units: metres and pixels. Sources: Mur-Artal and Tardós, "ORB-SLAM2", T-RO 2017, eq. 3,
// 4; docs/notes/018-depth-noise.md for the disparity's variance.
//
// Depth of a depth sensor is written as the disparity of a virtual baseline because noise that grows with z^2 is
// constant in it. The baseline's length cancels out: residual and sigma of the third row are both proportional to bf.
#pragma once

#include <Eigen/Core>
#include <algorithm>

#include "covis/geometry/camera.h"

namespace covis {

// Chi-square at 95 % for measurements of 1, 2 and 3 rows.
inline constexpr double kChi2One = 3.841;
inline constexpr double kChi2Mono = 5.991;
inline constexpr double kChi2Stereo = 7.815;

inline constexpr double kMinDepth = 1e-6;  // metres: nearer points, and points behind the camera, have no residual

struct PredictedMeasurement {
  double u = 0, v = 0;   // pixels
  double disparity = 0;  // pixels; 0 without a baseline
};

// Evaluates h(p_c) for a point in front of the camera.
inline PredictedMeasurement predict_measurement(const Eigen::Vector3d& p_c, const Pinhole& camera) {
  const double iz = 1 / p_c.z();
  return {camera.fx * p_c.x() * iz + camera.cx, camera.fy * p_c.y() * iz + camera.cy, camera.bf * iz};
}

inline constexpr float kLeastDisparity = 0.01f;  // pixels, of a pair: what is farther counts as being there

// The third row of a measurement.
struct Disparity {
  float pixels = 0;      // 0: not measured
  float inv_sigma2 = 0;  // 1 / pixels^2

  bool measured() const { return pixels > 0; }
  friend bool operator==(const Disparity&, const Disparity&) = default;
};

// The disparity that a depth (metres, positive) stands for.
inline float pixels_of_depth(const Pinhole& camera, float depth) {
  return static_cast<float>(camera.bf * (1 / static_cast<double>(depth)));
}

// The variance of a depth's logarithm by the position of its keypoint, for surfaces are seen at a slant.
inline double relative_position_variance(const Pinhole& camera, double inv_sigma2) {
  constexpr double kSlope = 0.5;  // half a sigma of the keypoint's position, on a surface at 45 degrees (note 18)
  const double slope = kSlope / camera.fx;
  return slope * slope / inv_sigma2;
}

// The factor by which a depth sensor's sigma is multiplied for the weight of its depths. Errors of a depth image are
// alike around a point and from frame to frame (calibration, registration to the image, outlines), so that n depths
// tell less than n independent ones: 2 means that four of them tell no more than one. Measured:
// docs/notes/018-depth-noise.md.
inline constexpr double kAlikeErrors = 2;

// The disparity that a measured depth (metres; not positive: none) stands for; `inv_sigma2`: that of the keypoint. None
// for a camera without a baseline.
inline Disparity disparity_of_depth(const Pinhole& camera, float depth, float inv_sigma2) {
  if (!(depth > 0) || !(camera.bf > 0)) return {};
  const double iz = 1 / static_cast<double>(depth);
  const float pixels = pixels_of_depth(camera, depth);
  if (!camera.depth_noise.known()) return {pixels, inv_sigma2};
  const double sensor = kAlikeErrors * camera.depth_noise.sigma(depth) * iz;
  const double relative2 = sensor * sensor + relative_position_variance(camera, inv_sigma2);
  return {pixels, static_cast<float>(1 / (relative2 * camera.bf * iz * camera.bf * iz))};
}

// The residual from its parts: those of u, v and the disparity.
inline Eigen::Vector3d residual_of(double u, double v, double d, const Pinhole& camera, const Disparity& disparity) {
  if (!disparity.measured()) return {u, v, 0};
  return {u, v, camera.depth_noise.known() ? d : u - d};
}

// Evaluates z - h(p_c); row 2 is 0 when no disparity was measured. For a stereo camera it is that of the right column,
// u - disparity, as published; for a depth sensor that of the disparity alone, which knows nothing of u's error.
inline Eigen::Vector3d reprojection_residual(const Eigen::Vector3d& p_c, const Pinhole& camera, float u, float v,
                                             const Disparity& disparity) {
  const PredictedMeasurement h = predict_measurement(p_c, camera);
  return residual_of(u - h.u, v - h.v, disparity.pixels - h.disparity, camera, disparity);
}

// The squared residuals of a measurement divided by their variances.
struct Chi2 {
  double pixel = 0;      // error of u and v
  double disparity = 0;  // 0 when none was measured

  Chi2(const Eigen::Vector3d& residual, double inv_sigma2, const Disparity& d)
      : pixel((residual.x() * residual.x() + residual.y() * residual.y()) * inv_sigma2),
        disparity(residual.z() * residual.z() * static_cast<double>(d.inv_sigma2)) {}
  double sum() const { return pixel + disparity; }
};

// True within the 95 % bound. A depth sensor's depth is wrong beside outlines, where the pixel is right: it counts
// against a measurement up to its own bound only.
inline bool within_bound(const Chi2& chi2, const Pinhole& camera, const Disparity& disparity) {
  if (!disparity.measured()) return chi2.pixel <= kChi2Mono;
  if (!camera.depth_noise.known()) return chi2.sum() <= kChi2Stereo;
  return chi2.pixel + std::min(chi2.disparity, kChi2One) <= kChi2Stereo;
}

}  // namespace covis
