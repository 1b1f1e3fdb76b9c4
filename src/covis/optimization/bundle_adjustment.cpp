// SPDX-License-Identifier: Apache-2.0
#include "covis/optimization/bundle_adjustment.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "covis/optimization/bundle_workspace.h"
#include "covis/optimization/free_scale.h"
#include "covis/optimization/reprojection.h"

namespace covis {
namespace {

bool stopped(const BundleOptions& options) {
  return options.interrupt && options.interrupt->load(std::memory_order_relaxed);
}

// The pose that alone holds a problem in which no depth tells the scale; nothing where something tells it.
std::optional<size_t> only_hold(const BundleProblem& problem) {
  if (std::count(problem.fixed.begin(), problem.fixed.end(), 1) != 1) return std::nullopt;
  const auto has_depth = [](const BundleObservation& o) { return o.active && o.disparity.measured(); };
  if (std::any_of(problem.observations.begin(), problem.observations.end(), has_depth)) return std::nullopt;
  return static_cast<size_t>(std::find(problem.fixed.begin(), problem.fixed.end(), 1) - problem.fixed.begin());
}

}  // namespace

BundleAdjuster::BundleAdjuster() : workspace_(std::make_unique<Workspace>()) {}
BundleAdjuster::~BundleAdjuster() = default;

BundleSummary BundleAdjuster::solve(BundleProblem& problem, const BundleOptions& options) {
  Workspace& w = *workspace_;
  BundleSummary summary;
  w.prepare(problem);
  if (w.sorted.empty()) {
    summary.ok = false;
    return summary;
  }
  const std::optional<size_t> hold = only_hold(problem);
  const std::vector<double> distances = hold ? distances_from(*hold, problem) : std::vector<double>();
  double lambda = 1e-4, growth = 2;
  const Loss loss = options.robust ? Loss::huber : Loss::squared;
  double cost = w.linearise(problem, loss);
  summary.initial_cost = summary.final_cost = cost;
  bool stepped = false;
  for (; summary.iterations < options.iterations; ++summary.iterations) {
    if (stopped(options)) {
      summary.interrupted = true;
      break;
    }
    if (!w.solve_step(lambda)) {
      lambda *= growth;
      growth *= 2;
      continue;
    }
    w.poses_try = problem.poses;
    w.points_try = problem.points;
    double gain = 0;  // decrease predicted by the linear model
    for (size_t c = 0; c < w.free_index.size(); ++c) {
      const auto pose = static_cast<size_t>(w.free_index[c]);
      const Vector6d step = w.step_c.segment<6>(static_cast<Eigen::Index>(c) * 6);
      gain += step.dot(lambda * w.U[c].diagonal().cwiseProduct(step) + w.b_c[c]);
      w.poses_try[pose] = SE3::exp(step) * problem.poses[pose];
    }
    for (size_t p = 0; p < w.points_try.size(); ++p) {
      gain += w.step_p[p].dot(lambda * w.V[p].diagonal().cwiseProduct(w.step_p[p]) + w.b_p[p]);
      w.points_try[p] += w.step_p[p];
    }
    const double next = w.cost(problem, w.poses_try, w.points_try, loss);
    const double ratio = (cost - next) / std::max(gain, 1e-300);
    if (std::isfinite(next) && next <= cost) {
      std::swap(problem.poses, w.poses_try);
      std::swap(problem.points, w.points_try);
      const bool done = cost - next <= options.relative_cost_change * cost;
      stepped = true;
      const double r = 2 * ratio - 1;
      lambda = std::max(1e-12, lambda * std::clamp(1 - r * r * r, 1.0 / 3, 2.0));
      growth = 2;
      summary.final_cost = cost = next;
      if (done) {
        ++summary.iterations;
        break;
      }
      cost = w.linearise(problem, loss);
    } else {
      lambda *= growth;
      growth *= 2;
      if (lambda > 1e12) break;
    }
  }
  for (const int32_t pose : w.free_index) {
    SE3& T = problem.poses[static_cast<size_t>(pose)];
    T = T.normalized();
  }
  // The steps change the scale where nothing holds it, by some per cent at once.
  if (hold && stepped) {
    restore_scale(*hold, distances, w.free_index, w.point_moves, problem);
  }
  summary.ok = std::isfinite(cost) && (stepped || cost < 1e-12 || summary.iterations > 0);
  return summary;
}

int classify_observations(BundleProblem& problem) {
  int inactive = 0;
  for (BundleObservation& o : problem.observations) {
    const Eigen::Vector3d p_c =
        problem.poses[static_cast<size_t>(o.pose)] * problem.points[static_cast<size_t>(o.point)];
    const Pinhole& camera = problem.camera;
    o.active = p_c.z() > kMinDepth &&
               within_bound(Chi2(reprojection_residual(p_c, camera, o.u, o.v, o.disparity), o.inv_sigma2, o.disparity),
                            camera, o.disparity);
    inactive += !o.active;
  }
  return inactive;
}

double degrees_of_freedom(const BundleProblem& problem) {
  double freedom = -3.0 * static_cast<double>(problem.points.size());
  for (const BundleObservation& o : problem.observations) freedom += !o.active ? 0 : o.disparity.measured() ? 3 : 2;
  for (const uint8_t fixed : problem.fixed) freedom -= fixed ? 0 : 6;
  return freedom;
}

}  // namespace covis
