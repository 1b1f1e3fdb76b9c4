// SPDX-License-Identifier: Apache-2.0
// Estimates how far the columns of a pair's right image are off in a bundle problem: motion tells the depths of points
// up to a scale that is one for all, so that disparities that depend on the place in the image otherwise than depths do
// show it. One adjustment for each term of the field tells how residuals change with it when poses and points have
// followed, so that the field is a linear least squares problem.
// Source: Triggs, McLauchlan, Hartley, Fitzgibbon, "Bundle Adjustment: A Modern Synthesis", 2000 (reduced cost of a
// subset of the parameters, section 6.1). Measured: docs/notes/063-what-rectification-left.md.
#pragma once

#include <atomic>
#include <optional>

#include "covis/geometry/shift_field.h"
#include "covis/optimization/bundle_adjustment.h"

namespace covis {

struct ColumnsEstimate {
  ShiftField field;  // beyond that which was taken out of the disparities
  double size = 0;   // the field's root mean square over observations, pixels
  // The standard deviation of that: as if all errors were independent, or as 4, 8 or 16 pieces of the map scatter,
  // whichever is the greatest.
  double noise = 0;
};

// `problem` must have been adjusted and its outliers classified. The estimate works on copies of it, without robust
// weights. Its poses are in the order of time. Nothing: interrupted, or the problem does not tell it.
std::optional<ColumnsEstimate> estimate_columns(const BundleProblem& problem, BundleAdjuster& adjuster,
                                                const std::atomic<bool>* interrupt = nullptr);

// Takes a field out of the problem's disparities, and puts it into its camera. False, and nothing done: some
// observation would be moved by more pixels than a rectification leaves.
bool take_out(const ShiftField& field, BundleProblem& problem);

}  // namespace covis
