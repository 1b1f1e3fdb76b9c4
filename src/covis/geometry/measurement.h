// SPDX-License-Identifier: Apache-2.0
// The measurement of a point by a camera: z = h(p_c) = (u, v, u - bf / depth); the third row exists only with a stereo
// or depth sensor. Searches, checks and solvers all call this h, so that another camera model needs changes in one
// place only. (The pose optimisation alone repeats it, in the order of operations that is fastest.) Units: metres and
// pixels. Source: Mur-Artal and Tardós, "ORB-SLAM2", T-RO 2017, eq. 3, 4.
#pragma once

#include <Eigen/Core>

#include "covis/geometry/camera.h"

namespace covis {

// Chi-square at 95 % for measurements of 2 and 3 rows.
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

// Evaluates z - h(p_c); row 2 is 0 when u_right is negative.
inline Eigen::Vector3d reprojection_residual(const Eigen::Vector3d& p_c, const Pinhole& camera, float u, float v,
                                             float u_right) {
  const PredictedMeasurement h = predict_measurement(p_c, camera);
  return {u - h.u, v - h.v, u_right >= 0 ? u_right - (h.u - h.disparity) : 0.0};
}

// The 95 % bound on a measurement's squared residual divided by its variance.
inline double chi2_bound(float u_right) { return u_right >= 0 ? kChi2Stereo : kChi2Mono; }

}  // namespace covis
