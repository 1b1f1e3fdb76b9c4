// SPDX-License-Identifier: Apache-2.0
// The one check of a camera, wherever it comes from: a camera file, a recording's own calibration, a bag, a program.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "covis/geometry/camera.h"

namespace covis {

// Bounds of a camera that can be used, pixels and metres.
struct CameraBounds {
  static constexpr int kLeastSide = 16, kLargestSide = 20000;
  static constexpr double kLeastFocal = 1, kLargestFocal = 1e5;
  static constexpr double kLeastBaseline = 1e-4, kLargestBaseline = 100;
  static constexpr double kLargestCoefficient = 1e6;  // any coefficient of a lens
  static constexpr double kLongestReadout = 0.2;      // seconds from the first row to the last
};

// Names the figure of a camera that is out of bounds, not finite or contradicts the others, its value and what would be
// right. nullopt where all can be used. A baseline is optional.
std::optional<std::string> problem_of(const Camera& camera);

// Says why the two cameras of a rectified pair (with one size) cannot be those of one: other focal lengths, or another
// principal point than depth is computed with.
std::optional<std::string> problem_of_pair(const Pinhole& left, const Pinhole& right);

// Says what of a camera that can be used is hardly that of real images that can be tracked: few pixels, focal
// lengths that contradict each other, an absurd field of view.
std::vector<std::string> doubts_about(const Camera& camera);

}  // namespace covis
