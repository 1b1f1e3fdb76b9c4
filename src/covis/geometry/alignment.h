// SPDX-License-Identifier: Apache-2.0
// The similarity or rigid transform that best maps one point set to another. Source: Horn, JOSA A 1987; Umeyama,
// "Least-squares estimation of transformation parameters between two point patterns", PAMI 1991, eq. 40 to 43.
#pragma once

#include <optional>
#include <span>

#include "covis/geometry/se3.h"

namespace covis {

struct Alignment {
  SE3 T_ba;  // for alignment with `scale`: b ~ scale * R * a + t
  double scale = 1;
  double rmse = 0;     // root mean square of the remaining distances
  bool unique = true;  // false: the points lie on a line, and the rotation about it is arbitrary

  Eigen::Vector3d operator*(const Eigen::Vector3d& a) const { return scale * (T_ba.R() * a) + T_ba.t(); }
};

enum class Scale { fixed, free };

// Returns nullopt for fewer than 3 points, sets of different sizes, non-finite points, or points that all coincide.
std::optional<Alignment> align(std::span<const Eigen::Vector3d> a, std::span<const Eigen::Vector3d> b, Scale scale);

}  // namespace covis
