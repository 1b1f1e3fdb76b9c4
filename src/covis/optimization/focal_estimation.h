// SPDX-License-Identifier: Apache-2.0
// Estimates a correction factor for the focal length of a bundle problem's camera. The adjusted cost as a function of
// the focal length is nearly a parabola. Three adjustments determine its minimum, and its width gives the uncertainty.
// How well is estimated twice: as if all errors were independent, and as pieces of the map scatter, for errors of
// neighbouring key frames are alike (a sandwich of their gradients: White, "Maximum likelihood estimation of
// misspecified models", Econometrica 1982). Measured: docs/notes/020-focal-length-only-where-it-is-sure.md.
// Source: Triggs, McLauchlan, Hartley, Fitzgibbon, "Bundle Adjustment: A Modern Synthesis", 2000 (reduced cost of a
// subset of the parameters, section 6.1; covariance from it, section 9.3.3).
#pragma once

#include <atomic>
#include <optional>

#include "covis/optimization/bundle_adjustment.h"

namespace covis {

struct FocalEstimate {
  bool ok = false;      // false: interrupted, or no minimum nearby (motion that does not constrain the focal length)
  double factor = 1;    // best factor for fx and fy
  double sigma = 0;     // standard deviation of the factor; the noise is estimated from the cost itself
  double scatter = 0;   // the same as pieces of the map scatter: the greatest of 4, 8 and 16 pieces
  bool agreed = false;  // columns and rows of the image, each by itself, say what both say together
  double cost = 0;      // adjusted cost at factor 1
  double variance = 0;  // observation variance relative to the given one; 1 sigma raises the cost by this much
};

// `problem` must have been adjusted and its outliers classified. The estimate works on copies of it, without robust
// weights. Its poses are in the order of time.
FocalEstimate estimate_focal(const BundleProblem& problem, BundleAdjuster& adjuster,
                             const std::atomic<bool>* interrupt = nullptr);

// Adjusts the problem until convergence, as the estimate does: without robust weights, so that costs are comparable.
// Returns nullopt when interrupted.
std::optional<double> adjusted_cost(BundleProblem& problem, BundleAdjuster& adjuster,
                                    const std::atomic<bool>* interrupt = nullptr);

// Returns the camera with its focal lengths multiplied by `factor`; bf is unchanged.
Pinhole with_focal(const Pinhole& camera, double factor);

}  // namespace covis
