// SPDX-License-Identifier: Apache-2.0
#include "covis/optimization/focal_estimation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "covis/geometry/alike_errors.h"
#include "covis/geometry/measurement.h"
#include "covis/optimization/reprojection.h"

namespace covis {
namespace {

constexpr double kStep = 0.01;  // difference of the factor between the three adjustments

// The cost of a part of the problem as a parabola of the factor, given at the three of them.
struct Parabola {
  std::array<double, 3> cost{};

  void add(const Parabola& other) {
    for (size_t k = 0; k < cost.size(); ++k) cost[k] += other.cost[k];
  }
  double slope() const { return (cost[2] - cost[0]) / (2 * kStep); }
  double curvature() const { return (cost[0] + cost[2] - 2 * cost[1]) / (kStep * kStep); }
  double minimum() const { return -slope() / curvature(); }  // the factor less 1
};

// The cost of each pose's observations, in columns and in rows of the image and by their depths.
struct CostShares {
  std::vector<Parabola> columns, rows, depths;

  explicit CostShares(size_t poses) : columns(poses), rows(poses), depths(poses) {}
  void add(const BundleProblem& problem, size_t k) {
    for (const BundleObservation& o : problem.observations) {
      if (!o.active) continue;
      const auto pose = static_cast<size_t>(o.pose);
      const Eigen::Vector3d p_c = problem.poses[pose] * problem.points[static_cast<size_t>(o.point)];
      const Eigen::Vector3d r = reprojection_residual(p_c, problem.camera, o.u, o.v, o.disparity);
      const auto inv_sigma2 = static_cast<double>(o.inv_sigma2);
      columns[pose].cost[k] += r.x() * r.x() * inv_sigma2;
      rows[pose].cost[k] += r.y() * r.y() * inv_sigma2;
      const Chi2 chi2(r, inv_sigma2, o.disparity);
      depths[pose].cost[k] += robust_cost(chi2, problem.camera, o.disparity, Loss::squared).cost - chi2.pixel;
    }
  }
};

// Standard deviation of the minimum when the errors of each of so many parts, poses that follow one another, are one.
double scatter_of(const CostShares& shares, const Parabola& all, size_t parts) {
  const size_t poses = shares.columns.size();
  double sum = 0;
  for (size_t part = 0; part < parts; ++part) {
    Parabola mine;
    for (size_t pose = part * poses / parts; pose < (part + 1) * poses / parts; ++pose) {
      mine.add(shares.columns[pose]);
      mine.add(shares.rows[pose]);
      mine.add(shares.depths[pose]);
    }
    const double slope = mine.slope() + mine.curvature() * all.minimum();
    sum += slope * slope;
  }
  const auto n = static_cast<double>(parts);
  return std::sqrt(sum * n / (n - 1)) / all.curvature();
}

// Where both axes tell much by themselves, their minima must lie on the same side, neither twice as far as the other.
bool axes_agree(const CostShares& shares, const Parabola& all) {
  constexpr double kTells = 0.15;  // share of the curvature
  constexpr double kFarther = 2;
  Parabola columns, rows;
  for (const Parabola& pose : shares.columns) columns.add(pose);
  for (const Parabola& pose : shares.rows) rows.add(pose);
  if (std::min(columns.curvature(), rows.curvature()) < kTells * all.curvature()) return true;
  const double ratio = columns.minimum() / rows.minimum();
  return ratio > 1 / kFarther && ratio < kFarther;
}

}  // namespace

FocalEstimate estimate_focal(const BundleProblem& problem, BundleAdjuster& adjuster,
                             const std::atomic<bool>* interrupt) {
  constexpr double kLeastVariance = 1e-6;  // no keypoint is more precise than a thousandth of its sigma
  FocalEstimate estimate;
  Parabola all;
  CostShares shares(problem.poses.size());
  for (size_t k = 0; k < 3; ++k) {
    BundleProblem copy = problem;
    copy.camera = with_focal(problem.camera, 1 + kStep * (static_cast<double>(k) - 1));
    const std::optional<double> cost = adjusted_cost(copy, adjuster, interrupt);
    if (!cost) return estimate;
    all.cost[k] = *cost;
    shares.add(copy, k);
  }
  const double curvature = all.curvature();
  const double freedom = degrees_of_freedom(problem);
  if (!(curvature > 0) || !(freedom > 0)) return estimate;
  estimate.cost = all.cost[1];
  estimate.variance = std::max(estimate.cost / freedom, kLeastVariance);
  estimate.factor = 1 + all.minimum();
  estimate.sigma = std::sqrt(2 * estimate.variance / curvature);
  for (const size_t parts : kNumbersOfPieces)
    estimate.scatter = std::max(estimate.scatter, scatter_of(shares, all, parts));
  estimate.agreed = axes_agree(shares, all);
  estimate.ok = std::isfinite(estimate.factor) && std::isfinite(estimate.sigma) && std::isfinite(estimate.scatter);
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
