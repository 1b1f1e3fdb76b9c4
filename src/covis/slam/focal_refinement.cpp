// SPDX-License-Identifier: Apache-2.0
#include "covis/slam/focal_refinement.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "covis/optimization/focal_estimation.h"

namespace covis {

// Not while there are several submaps, which all would have to follow.
std::optional<int> FocalSchedule::ask(const Map& map) {
  if (map.next_serial() < next_ || map.key_frame_count() > kLargest || map.submaps().size() != 1) return std::nullopt;
  next_ = map.next_serial() + std::max(kLeastStep, map.next_serial() / kStepShare);
  return kLeastAge + static_cast<int>(map.key_frame_count()) / kAgeShare;
}

namespace {

// One step; false: the problem stays as it was.
bool step(BundleProblem& problem, BundleAdjuster& adjuster, double given_fx, const std::atomic<bool>* interrupt) {
  constexpr double kMaxSigma = 0.005;   // of the factor: it is known well
  constexpr double kMinChange = 0.006;  // worth it …
  constexpr double kSignificant = 6;    // … and so many sigmas: errors of neighbouring key frames are alike
  constexpr double kMaxStep = 0.02;     // twice as far as the estimate looks: the next step goes on from there
  constexpr double kMaxChange = 0.05;   // from the one given
  const FocalEstimate estimate = estimate_focal(problem, adjuster, interrupt);
  if (!estimate.ok || estimate.sigma > kMaxSigma) return false;
  if (std::abs(estimate.factor - 1) < std::max(kMinChange, kSignificant * estimate.sigma)) return false;
  const Pinhole camera = with_focal(problem.camera, std::clamp(estimate.factor, 1 - kMaxStep, 1 + kMaxStep));
  if (std::abs(camera.fx / given_fx - 1) > kMaxChange) return false;

  BundleProblem moved = problem;
  moved.camera = camera;
  const std::optional<double> cost = adjusted_cost(moved, adjuster, interrupt);
  if (!cost || estimate.cost - *cost < kSignificant * kSignificant * estimate.variance) return false;
  const BundleSummary summary = adjuster.solve(moved, {.iterations = 20, .interrupt = interrupt});
  if (!summary.ok || summary.interrupted) return false;
  classify_observations(moved);
  problem = std::move(moved);
  return true;
}

}  // namespace

bool refine_focal(BundleProblem& problem, BundleAdjuster& adjuster, double given_fx,
                  const std::atomic<bool>* interrupt) {
  constexpr int kSteps = 3;
  int steps = 0;
  while (steps < kSteps && step(problem, adjuster, given_fx, interrupt)) ++steps;
  return steps > 0;
}

}  // namespace covis
