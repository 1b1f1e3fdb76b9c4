// SPDX-License-Identifier: Apache-2.0
#include "covis/loops/distortion_refinement.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "covis/optimization/lens_adjustment.h"

namespace covis {
namespace {

constexpr size_t kLeastPoses = 30;  // fewer are too alike: their scatter says too little
constexpr int kLeastObservers = 3;  // two views fit nearly any point
constexpr double kShown = 5;        // standard deviations
constexpr double kMostBent = 0.25;  // greatest shift at the images' border, as a share of the distance to the middle
constexpr Lens kUsual{.k1 = 0.3, .k2 = 0.1};  // standard deviations over lenses

// The problem in pixels of the images as they were given, with one focal length for columns and rows, and without
// points that few see.
BundleProblem as_given(const BundleProblem& problem) {
  const Pinhole& camera = problem.camera;
  BundleProblem given = problem;
  given.camera.fy = camera.fx;
  std::vector<int> observers(given.points.size());
  for (const BundleObservation& o : given.observations) observers[static_cast<size_t>(o.point)] += o.active;
  for (BundleObservation& o : given.observations) {
    o.active = o.active && observers[static_cast<size_t>(o.point)] >= kLeastObservers;
    const Eigen::Vector2d at = camera.bent({o.u, o.v});
    o.u = static_cast<float>(at.x());
    o.v = static_cast<float>(camera.cy + camera.fx / camera.fy * (at.y() - camera.cy));
  }
  return given;
}

// Keypoints straightened for `camera` instead of the problem's camera, which becomes it.
void straighten(BundleProblem& problem, const Pinhole& camera) {
  for (BundleObservation& o : problem.observations) {
    const Eigen::Vector2d at = camera.straightened(problem.camera.bent({o.u, o.v}));
    o.u = static_cast<float>(at.x());
    o.v = static_cast<float>(at.y());
  }
  problem.camera = camera;
}

// By how much the distortion shifts what is farthest out, as a share of its distance from the middle.
double most_bent(const BundleProblem& problem, const Lens& lens) {
  double most = 0;
  for (const BundleObservation& o : problem.observations) {
    const double r2 = problem.camera.unproject(o.u, o.v).head<2>().squaredNorm();
    most = std::max(most, std::abs(lens.k1 * r2 + lens.k2 * r2 * r2));
  }
  return most;
}

bool shows(const LensAdjustment& found) {
  const Lens deviation = found.deviation();
  return std::abs(found.lens.k1) > kShown * deviation.k1 || std::abs(found.lens.k2) > kShown * deviation.k2;
}

}  // namespace

bool refine_distortion(BundleProblem& problem, BundleAdjuster& adjuster, double given_fx,
                       const std::atomic<bool>* interrupt) {
  if (problem.poses.size() < kLeastPoses) return false;
  const auto interrupted = [&] { return interrupt && *interrupt; };
  const Pinhole& before = problem.camera;
  BundleProblem with_lens = as_given(problem), with_focal = with_lens;
  const Lens begin{.focal = given_fx, .k1 = before.residual.k1, .k2 = before.residual.k2};
  const LensAdjustment found =
      adjust_lens(with_lens, begin, {.usual = kUsual, .usual_focal = 0, .interrupted = interrupted});
  if (!found.ok || !shows(found) || most_bent(problem, found.lens) > kMostBent) return false;
  // Another focal length may explain the same.
  const LensAdjustment plain = adjust_lens(with_focal, {.focal = before.fx}, {.usual = {}, .interrupted = interrupted});
  if (interrupted() || (plain.ok && plain.variance <= found.variance)) return false;

  Pinhole camera = before;
  camera.fx = given_fx;
  camera.fy = before.fy / before.fx * given_fx;
  camera.residual = {found.lens.k1, found.lens.k2};
  BundleProblem moved = problem;
  moved.poses = std::move(with_lens.poses);
  moved.points = std::move(with_lens.points);
  straighten(moved, camera);
  const BundleSummary summary = adjuster.solve(moved, {.iterations = 20, .interrupt = interrupt});
  if (!summary.ok || summary.interrupted) return false;
  classify_observations(moved);
  problem = std::move(moved);
  return true;
}

}  // namespace covis
