// SPDX-License-Identifier: Apache-2.0
// The scale of a problem that one pose alone holds and no depth tells: an adjustment changes it by some per cent, and
// it is restored afterwards, so that the median ratio of the points' distances from that pose, after to before, is 1.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "covis/optimization/bundle_adjustment.h"

namespace covis {

// The distances of all points from the centre of one pose.
std::vector<double> distances_from(size_t pose, const BundleProblem& problem);

// Scales what was moved, the poses of these indices and the points by a flag each, about the centre of the pose that
// held. `distances`: from there, before the adjustment.
void restore_scale(size_t pose, const std::vector<double>& distances, const std::vector<int32_t>& moved_poses,
                   const std::vector<uint8_t>& moved, BundleProblem& problem);
// All other poses moved, and all points with active observations.
void restore_scale(size_t pose, const std::vector<double>& distances, BundleProblem& problem);

}  // namespace covis
