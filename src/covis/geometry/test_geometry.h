// SPDX-License-Identifier: Apache-2.0
// For the tests of geometry: things drawn at random, and how far two transforms are apart.
#pragma once

#include <cmath>
#include <numbers>
#include <vector>

#include "covis/core/random.h"
#include "covis/geometry/se3.h"
#include "covis/geometry/sim3.h"

namespace covis {

inline Eigen::Vector3d random_vector(Random& random, double size) {
  return {random.uniform(-size, size), random.uniform(-size, size), random.uniform(-size, size)};
}

inline double distance(const SE3& a, const SE3& b) { return (a.R() - b.R()).norm() + (a.t() - b.t()).norm(); }

inline double distance(const Sim3& a, const Sim3& b) {
  return (a.R() - b.R()).norm() + (a.t() - b.t()).norm() + std::abs(a.scale() - b.scale());
}

// Zero, tiny, random, near half a turn, rotation alone, scale alone.
inline std::vector<Vector7d> similarity_tangents() {
  Random random(5);
  std::vector<Vector7d> list{Vector7d::Zero(), Vector7d::Constant(1e-8)};
  for (int k = 0; k < 60; ++k) {
    Vector7d xi;
    for (int i = 0; i < 7; ++i) xi(i) = random.uniform(-1, 1);
    xi.segment<3>(3) *= (k % 5 == 0 ? std::numbers::pi - 1e-3 : random.uniform(0, 3)) / xi.segment<3>(3).norm();
    if (k % 7 == 0) xi(6) = 0;
    if (k % 11 == 0) xi.segment<3>(3).setZero();
    list.push_back(xi);
  }
  return list;
}

}  // namespace covis
