// SPDX-License-Identifier: Apache-2.0
#include "covis/optimization/focal_estimation.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace covis {

FocalEstimate estimate_focal(const BundleProblem& problem, BundleAdjuster& adjuster,
                             const std::atomic<bool>* interrupt) {
  constexpr double kStep = 0.01;           // difference of the factor between the three adjustments
  constexpr double kLeastVariance = 1e-6;  // no keypoint is more precise than a thousandth of its sigma
  FocalEstimate estimate;
  std::array<double, 3> costs{};
  for (size_t k = 0; k < 3; ++k) {
    BundleProblem copy = problem;
    copy.camera = with_focal(problem.camera, 1 + kStep * (static_cast<double>(k) - 1));
    const std::optional<double> cost = adjusted_cost(copy, adjuster, interrupt);
    if (!cost) return estimate;
    costs[k] = *cost;
  }
  const double curvature = costs[0] + costs[2] - 2 * costs[1];
  double freedom = -3.0 * static_cast<double>(problem.points.size());
  for (const BundleObservation& o : problem.observations) freedom += !o.active ? 0 : o.disparity.measured() ? 3 : 2;
  for (const uint8_t fixed : problem.fixed) freedom -= fixed ? 0 : 6;
  if (!(curvature > 0) || !(freedom > 0)) return estimate;
  estimate.cost = costs[1];
  estimate.variance = std::max(costs[1] / freedom, kLeastVariance);
  estimate.factor = 1 + kStep * (costs[0] - costs[2]) / (2 * curvature);
  estimate.sigma = kStep * std::sqrt(2 * estimate.variance / curvature);
  estimate.ok = std::isfinite(estimate.factor) && std::isfinite(estimate.sigma);
  return estimate;
}

std::optional<double> adjusted_cost(BundleProblem& problem, BundleAdjuster& adjuster,
                                    const std::atomic<bool>* interrupt) {
  const BundleSummary summary = adjuster.solve(
      problem, {.iterations = 40, .robust = false, .relative_cost_change = 1e-7, .interrupt = interrupt});
  if (!summary.ok || summary.interrupted) return std::nullopt;
  return summary.final_cost;
}

Pinhole with_focal(const Pinhole& camera, double factor) {
  Pinhole made = camera;
  made.fx *= factor;
  made.fy *= factor;
  return made;
}

}  // namespace covis
