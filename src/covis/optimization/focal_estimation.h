// SPDX-License-Identifier: Apache-2.0
// How much longer or shorter the focal length should be than a bundle problem's camera says: the adjusted cost as a
// function of the focal length is nearly a parabola, whose top three adjustments show and whose width tells how sure it
// is. Source: Triggs, McLauchlan, Hartley, Fitzgibbon, "Bundle Adjustment: A Modern Synthesis", 2000 (reduced cost of a
// subset of the parameters, section 6.1; covariance from it, section 9.3.3).
#pragma once

#include <atomic>
#include <optional>

#include "covis/optimization/bundle_adjustment.h"

namespace covis {

struct FocalEstimate {
  bool ok = false;    // false: interrupted, or the cost has no minimum near here (motion that tells nothing of it)
  double factor = 1;  // the best factor of fx and fy
  double sigma = 0;   // standard deviation of the factor, the noise taken from the cost itself
  double cost = 0;    // adjusted, at factor 1
  double variance =
      0;  // variance of an observation, in units of that it was given: a cost that is greater by so much is 1 sigma off
};

// `problem` must have been adjusted and its outliers classified: all is done on copies of it, without robust weights.
FocalEstimate estimate_focal(const BundleProblem& problem, BundleAdjuster& adjuster,
                             const std::atomic<bool>* interrupt = nullptr);

// Adjusts the problem until nothing is gained, as the estimate does: without robust weights, so that costs can be
// compared. Nothing when interrupted.
std::optional<double> adjusted_cost(BundleProblem& problem, BundleAdjuster& adjuster,
                                    const std::atomic<bool>* interrupt = nullptr);

// The camera with its focal lengths times `factor`; what depends on the baseline stays.
Pinhole with_focal(const Pinhole& camera, double factor);

}  // namespace covis
