// SPDX-License-Identifier: Apache-2.0
// How noisy a depth sensor is, by its depths against adjusted points: the factor by which the model's sigma
// (geometry/depth_noise.h) must be multiplied for the median of the squared errors to be that of a chi-square
// distribution. The median is not moved by depths beside outlines. Source: Rousseeuw and Leroy, "Robust regression and
// outlier detection", 1987 (scale from the median).
#pragma once

#include <optional>

#include "covis/optimization/bundle_adjustment.h"

namespace covis {

// `problem` must have been adjusted and its outliers classified. Points with three active depths or more tell; nullopt
// when they are few, or when the camera's noise is not that of a depth sensor.
std::optional<double> depth_noise_factor(const BundleProblem& problem);

}  // namespace covis
