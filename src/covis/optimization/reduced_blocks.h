// SPDX-License-Identifier: Apache-2.0
// A point's part of the dense reduced system of bundle adjustment (bundle_workspace.h), by SIMD with a scalar twin of
// the same bits.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <span>

namespace covis {

using Matrix6x3d = Eigen::Matrix<double, 6, 3>;

// One free pose that observes the point.
struct PoseOfPoint {
  int32_t pose = 0;  // among the free ones
  const Matrix6x3d* W = nullptr;
  Matrix6x3d Y;  // W V^-1
};

// Subtracts Y_i W_j' from block (pose of i, pose of j) of S for all i and j in the lower triangle. S: column-major, 6
// rows and columns a pose; `stride`: doubles from one column to the next.
void subtract_point(std::span<const PoseOfPoint> poses, double* S, ptrdiff_t stride);

}  // namespace covis
