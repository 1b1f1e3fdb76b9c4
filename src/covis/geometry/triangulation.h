// SPDX-License-Identifier: Apache-2.0
// Triangulation of a point from two views. Source: Hartley and Zisserman, "Multiple View Geometry", 2004, section 12.2
// (linear triangulation).
#pragma once

#include <Eigen/Core>
#include <optional>

#include "covis/geometry/se3.h"

namespace covis {

// The world point seen along ray_1 (camera 1, z = 1) and ray_2 (camera 2, z = 1); nullopt when it lies at infinity. It
// may lie behind a camera: the caller checks.
std::optional<Eigen::Vector3d> triangulate(const SE3& T_1w, const Eigen::Vector3d& ray_1, const SE3& T_2w,
                                           const Eigen::Vector3d& ray_2);

}  // namespace covis
