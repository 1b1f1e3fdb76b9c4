// SPDX-License-Identifier: Apache-2.0
// The distortion that a camera's images have although it was given without any: that of a phone whose focal length
// alone was looked up, or what rectification with a simpler model left. A focal length that is refined makes up for a
// part of it, and bends the map. Measured figures: docs/notes/050-distortion-that-was-left.md.
#pragma once

#include <atomic>

#include "covis/optimization/bundle_adjustment.h"

namespace covis {

// Moves an adjusted problem to the residual distortion that its observations show, when the problem is large enough, a
// coefficient differs from 0 by five standard deviations, observations agree better than with any focal length without
// distortion, and keypoints are elsewhere by 0.05 pixels. The focal length becomes the one that was given where that
// agrees with the observations, or another one, within 5 % of it, that is as sure as the distortion; between the two
// the problem stays. Observations become those of straightened keypoints; they have no disparities. False: the problem
// stays as it was.
bool refine_distortion(BundleProblem& problem, BundleAdjuster& adjuster, double given_fx,
                       const std::atomic<bool>* interrupt = nullptr);

}  // namespace covis
