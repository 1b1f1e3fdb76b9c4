// SPDX-License-Identifier: Apache-2.0
// An observation's part of the linear system of bundle adjustment (bundle_workspace.h), by SIMD with a scalar twin of
// the same bits.
#pragma once

#include <Eigen/Core>

#include "covis/geometry/se3.h"
#include "covis/optimization/reduced_blocks.h"

namespace covis {

// The derivatives of one residual: those by its pose transposed, so that a row of the Jacobian is contiguous.
struct WeightedJacobians {
  Matrix6x3d J_c, wJ_c;  // transposed; wJ: times the weights of the rows
  Eigen::Matrix3d J_p;
};

// Adds J_c' w J_c to U and J_c' w e to b, and sets W to J_c' w J_p.
void add_observation(const WeightedJacobians& jacobians, const Eigen::Vector3d& e, Matrix6d& U, Vector6d& b,
                     Matrix6x3d& W);

}  // namespace covis
