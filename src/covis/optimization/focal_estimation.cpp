// SPDX-License-Identifier: Apache-2.0
#include "covis/optimization/focal_estimation.h"

#include <array>
#include <cmath>

namespace covis {

FocalEstimate estimate_focal(const BundleProblem& problem, BundleAdjuster& adjuster,
                             const std::atomic<bool>* interrupt) {
  constexpr double kStep = 0.01;  // of the factor, between the three
  constexpr double kLeastCost = 1e-9;
  FocalEstimate estimate;
  std::array<double, 3> cost{};
  for (size_t k = 0; k < 3; ++k) {
    BundleProblem copy = problem;
    copy.camera = with_focal(problem.camera, 1 + kStep * (static_cast<double>(k) - 1));
    const BundleSummary summary =
        adjuster.solve(copy, {.iterations = 40, .robust = false, .relative_cost_change = 1e-7, .interrupt = interrupt});
    if (!summary.ok || summary.interrupted) return estimate;
    cost[k] = summary.final_cost;
  }
  const double curvature = cost[0] + cost[2] - 2 * cost[1];
  double freedom = -3.0 * static_cast<double>(problem.points.size());
  for (const BundleObservation& o : problem.observations) freedom += !o.active ? 0 : o.u_right >= 0 ? 3 : 2;
  for (const uint8_t fixed : problem.fixed) freedom -= fixed ? 0 : 6;
  if (!(curvature > kLeastCost) || !(freedom > 0)) return estimate;
  const double variance = cost[1] / freedom;  // of an observation, in units of the sigma it was given
  estimate.factor = 1 + kStep * (cost[0] - cost[2]) / (2 * curvature);
  estimate.sigma = kStep * std::sqrt(2 * variance / curvature);
  estimate.ok = std::isfinite(estimate.factor) && std::isfinite(estimate.sigma);
  return estimate;
}

Pinhole with_focal(const Pinhole& camera, double factor) {
  Pinhole made = camera;
  made.fx *= factor;
  made.fy *= factor;
  return made;
}

}  // namespace covis
