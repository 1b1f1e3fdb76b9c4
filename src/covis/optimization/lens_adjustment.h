// SPDX-License-Identifier: Apache-2.0
// Bundle adjustment in which the camera moves too: one focal length for columns and rows, the first two radial
// coefficients of Brown's model, and the principal point. It converges from a focal length that is wrong by a third,
// where the motion tells it, and says how sure it is. Small maps only: the reduced system is dense.
// Sources: Triggs et al., "Bundle adjustment, a modern synthesis", 2000 (Schur complement, section 6; covariance,
// section 9.3.3); Brown, "Close-range camera calibration", 1971.
#pragma once

#include <functional>
#include <limits>

#include "covis/optimization/bundle_adjustment.h"

namespace covis {

// The parameters of a camera that are adjusted, or their standard deviations: that of the focal length is a share of
// it.
struct Lens {
  double focal = 0;       // pixels
  double k1 = 0, k2 = 0;  // coefficients of Brown's model: radii in focal lengths
  double cx = 0, cy = 0;  // how far the principal point is off where the problem's camera has it, pixels
};

struct LensAdjustment {
  bool ok = false;          // false: interrupted, or nothing to solve
  Lens lens;                // as found
  Lens sigma;               // its standard deviations as if all errors were independent
  Lens scatter;             // the same as pieces of the map scatter: the greatest of 4, 8 and 16 pieces
  double variance = 0;      // observation variance relative to the given one
  size_t observations = 0;  // those within the 95 % bound

  Lens deviation() const;  // the greater of both standard deviations of each
};

struct LensOptions {
  // Standard deviations before anything was seen: of a lens' coefficients around 0, of the principal point around the
  // given one. A parameter with a deviation of 0 is kept there. The focal length has its own.
  Lens usual{.k1 = 0.3, .k2 = 0.1};
  // The same of the focal length's logarithm, around that of the lens the adjustment begins with; infinite: it is free.
  double usual_focal = std::numeric_limits<double>::infinity();
  std::function<bool()> interrupted = {};  // may be empty; true: end without a result
};

// Adjusts the problem's poses and points and the lens, which begins as `lens`. Observations are pixels of the image as
// it was given, not undistorted; without disparities. The first pose stays, and the scale goes where the steps take it
// (free_scale.h). Poses are in the order of time. What is not ok leaves the problem as it was.
LensAdjustment adjust_lens(BundleProblem& problem, const Lens& lens, const LensOptions& options = {});

}  // namespace covis
