// SPDX-License-Identifier: Apache-2.0
// Bundle adjustment in which the camera moves too: one focal length for columns and rows, and the first radial
// coefficient of Brown's model; the principal point stays. It converges from a focal length that is wrong by a third,
// where the motion tells it, and says how sure it is. Small maps only: the reduced system is dense.
// Sources: Triggs et al., "Bundle adjustment, a modern synthesis", 2000 (Schur complement, section 6; covariance,
// section 9.3.3); Brown, "Close-range camera calibration", 1971. Standard deviations are given twice, as those of
// focal_estimation.h: as if all errors were independent, and as pieces of the map scatter.
#pragma once

#include <atomic>

#include "covis/optimization/bundle_adjustment.h"

namespace covis {

// The parameters of a camera that are adjusted.
struct Lens {
  double focal = 0;  // pixels
  double k1 = 0;     // coefficient of Brown's model: radii in focal lengths
};

struct LensAdjustment {
  bool ok = false;          // false: interrupted, or nothing to solve
  Lens lens;                // as found
  double sigma = 0;         // standard deviation of the focal length, as a share of it
  double scatter = 0;       // the same as pieces of the map scatter: the greatest of 4, 8 and 16 pieces
  double k1_sigma = 0;      // the greater of both standard deviations of k1
  double variance = 0;      // observation variance relative to the given one
  size_t observations = 0;  // those within the 95 % bound
};

struct LensOptions {
  double usual_k1 = 0.3;  // standard deviation of k1 before anything was seen; 0: k1 stays
  const std::atomic<bool>* interrupt = nullptr;
};

// Adjusts the problem's poses and points and the lens, which begins as `lens`. Observations are pixels of the image as
// it was given, not undistorted; without disparities. The first pose stays. Poses are in the order of time.
LensAdjustment adjust_lens(BundleProblem& problem, const Lens& lens, const LensOptions& options = {});

}  // namespace covis
