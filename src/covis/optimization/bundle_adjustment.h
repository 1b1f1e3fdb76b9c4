// SPDX-License-Identifier: Apache-2.0
// Bundle adjustment, local and full: poses and points that minimise the robust reprojection error. Input and output are
// plain data; the code does not depend on the map. Where one pose alone is fixed and no observation has depth the scale
// is free: then the result is scaled so that the median ratio of the points' distances from the fixed pose, after to
// before, is 1.
// Source: Triggs et al., "Bundle adjustment, a modern synthesis", 2000 (Schur complement, section 6); Mur-Artal and
// Tardós, "ORB-SLAM2", T-RO 2017, section III-C. Levenberg-Marquardt damping: Nielsen, "Damping parameter in
// Marquardt's method", 1999.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <vector>

#include "covis/geometry/measurement.h"
#include "covis/geometry/se3.h"

namespace covis {

struct BundleObservation {
  int32_t pose = 0;       // index into poses
  int32_t point = 0;      // index into points
  float u = 0, v = 0;     // pixels, undistorted
  float inv_sigma2 = 1;   // weight of u and v, 1 / pixels^2
  Disparity disparity{};  // not measured: the observation has 2 rows only
  uint8_t active = 1;     // 0: not used (an outlier)
};

struct BundleProblem {
  std::vector<SE3> poses;                       // T_cw
  std::vector<uint8_t> fixed;                   // one per pose; 1: the pose does not move
  std::vector<Eigen::Vector3d> points;          // p_w; all of them move
  std::vector<BundleObservation> observations;  // any order
  Pinhole camera;
};

struct BundleOptions {
  int iterations = 10;                           // greatest number of Levenberg-Marquardt steps, accepted or rejected
  bool robust = true;                            // Huber: reprojection.h, robust_cost()
  double relative_cost_change = 1e-6;            // relative decrease of the cost below which the solver stops
  const std::atomic<bool>* interrupt = nullptr;  // when it becomes true the solver soon returns the last accepted state
};

struct BundleSummary {
  double initial_cost = 0, final_cost = 0;  // sum of rho(chi2) over the active observations
  int iterations = 0;
  bool interrupted = false;
  // False: there was nothing to solve, a value is not finite, or it was interrupted before it tried a step.
  bool ok = true;
};

// Keeps its workspace between calls. Not thread-safe.
class BundleAdjuster {
 public:
  BundleAdjuster();
  ~BundleAdjuster();
  BundleAdjuster(const BundleAdjuster&) = delete;
  BundleAdjuster& operator=(const BundleAdjuster&) = delete;

  BundleSummary solve(BundleProblem& problem, const BundleOptions& options);

 private:
  struct Workspace;
  std::unique_ptr<Workspace> workspace_;
};

// Sets observations inactive whose chi-square exceeds the 95 % bound or whose point is behind the camera, and the
// others active. Returns the number of inactive ones.
int classify_observations(BundleProblem& problem);
// The rows of all active observations less the unknowns.
double degrees_of_freedom(const BundleProblem& problem);

}  // namespace covis
