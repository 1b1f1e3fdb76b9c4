// SPDX-License-Identifier: Apache-2.0
// Small geometry of points and features that tracking and mapping share.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>

#include "covis/features/features.h"
#include "covis/geometry/se3.h"
#include "covis/matching/window_match.h"
#include "covis/optimization/pose_optimization.h"

namespace covis {

// The point of a feature with depth, in camera coordinates, metres.
inline Eigen::Vector3d unproject_depth(const Pinhole& camera, const Features& features, uint32_t feature) {
  const double z = features.depth[feature];
  return camera.unproject(features.x[feature], features.y[feature]) * z;
}

// Where a map point should appear in a camera, if it can be seen there at all.
struct PredictedView {
  float u = 0, v = 0;
  float u_right = -1;  // negative: the camera has no depth sensor
  float distance = 0;  // metres from the camera centre
  float cosine = 1;    // between the viewing ray and the point's mean viewing direction
  int level = 0;       // predicted pyramid level
};

struct PointAppearance {
  Eigen::Vector3d position_w;
  Eigen::Vector3f normal_w;
  float d_min = 0, d_max = 0;
};

// Nothing when it is behind the camera, outside the image, outside 0.8 d_min … 1.2 d_max, or seen at more than 60
// degrees from its mean viewing direction (ORB-SLAM, V-D).
inline std::optional<PredictedView> predict_view(const PointAppearance& point, const SE3& T_cw,
                                                 const Eigen::Vector3d& centre_w, const Pinhole& camera,
                                                 const Features& features) {
  const Eigen::Vector3d p_c = T_cw * point.position_w;
  if (!(p_c.z() > 0)) return std::nullopt;
  const double inv_z = 1 / p_c.z();
  PredictedView view;
  view.u = static_cast<float>(camera.fx * p_c.x() * inv_z + camera.cx);
  view.v = static_cast<float>(camera.fy * p_c.y() * inv_z + camera.cy);
  if (!features.grid.bounds.contains(view.u, view.v)) return std::nullopt;
  const Eigen::Vector3f ray = (point.position_w - centre_w).cast<float>();
  view.distance = ray.norm();
  if (view.distance < 0.8f * point.d_min || view.distance > 1.2f * point.d_max) return std::nullopt;
  view.cosine = ray.dot(point.normal_w) / view.distance;
  if (view.cosine < 0.5f) return std::nullopt;
  view.level = features.pyramid->predict_level(point.d_max, view.distance);
  if (camera.bf > 0) view.u_right = static_cast<float>(view.u - camera.bf * inv_z);
  return view;
}

// Squared reprojection error over the variance of feature i, and whether it is within the 95 % bound (2 or 3 rows).
// False for a point behind the camera.
inline bool reprojects_well(const Eigen::Vector3d& p_c, const Pinhole& camera, const Features& features, uint32_t i) {
  if (!(p_c.z() > 0)) return false;
  const Eigen::Vector2d pixel = camera.project(p_c);
  const double du = pixel.x() - features.x[i], dv = pixel.y() - features.y[i];
  const double inv_sigma2 = features.pyramid->inv_sigma2[features.level[i]];
  double chi2 = (du * du + dv * dv) * inv_sigma2;
  if (features.u_right[i] < 0) return chi2 <= kChi2Mono;
  const double dr = pixel.x() - camera.bf / p_c.z() - features.u_right[i];
  chi2 += dr * dr * inv_sigma2;
  return chi2 <= kChi2Stereo;
}

}  // namespace covis
