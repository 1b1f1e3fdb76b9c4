// SPDX-License-Identifier: Apache-2.0
// The geometry of a point and the keypoint that shows it, which searches, tracking and mapping share.
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "covis/features/features.h"
#include "covis/geometry/measurement.h"

namespace covis {

// The point of a feature with depth, in camera coordinates, metres.
inline Eigen::Vector3d unproject_depth(const Pinhole& camera, const Features& features, uint32_t feature) {
  const double z = features.depth[feature];
  return camera.unproject(features.x[feature], features.y[feature]) * z;
}

// The disparity of feature i, not measured when it has no depth.
inline Disparity disparity_of(const Features& features, size_t i, const Pinhole& camera) {
  return disparity_of_depth(camera, features.depth[i], features.pyramid->inv_sigma2[features.level[i]]);
}

// The standard deviation of a depth (metres), as a share of it; 0 without a sensor of depth.
inline double depth_noise_share(double depth, const Pinhole& camera) {
  constexpr double kDisparitySigma = 0.5;  // pixels
  if (camera.depth_noise.known()) return camera.depth_noise.sigma(depth) / depth;
  return camera.bf > 0 ? kDisparitySigma * depth / camera.bf : 0;
}

// True when that is little, so that the depth can contradict: noise of far depths is no contradiction.
inline bool is_precise_depth(double depth, const Pinhole& camera) {
  constexpr double kMostNoise = 0.05;
  return depth_noise_share(depth, camera) <= kMostNoise;
}

// True when a point lies within the 95 % bound of the measurement of feature i. False for a point behind the camera.
inline bool reprojects_well(const Eigen::Vector3d& p_c, const Pinhole& camera, const Features& features, uint32_t i) {
  if (!(p_c.z() > 0)) return false;
  const Disparity disparity = disparity_of(features, i, camera);
  const Eigen::Vector3d r = reprojection_residual(p_c, camera, features.x[i], features.y[i], disparity);
  return within_bound(Chi2(r, features.pyramid->inv_sigma2[features.level[i]], disparity), camera, disparity);
}

}  // namespace covis
