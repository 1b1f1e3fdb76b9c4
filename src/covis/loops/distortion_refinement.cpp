// SPDX-License-Identifier: Apache-2.0
#include "covis/loops/distortion_refinement.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "covis/optimization/free_scale.h"
#include "covis/optimization/lens_adjustment.h"

namespace covis {
namespace {

constexpr size_t kLeastPoses = 30;            // fewer are too alike: their scatter says too little
constexpr int kLeastObservers = 3;            // two views fit nearly any point
constexpr double kMaxChange = 0.05;           // greatest change of the focal length, as a share
constexpr double kLeastShift = 0.05;          // pixels: worth moving the map for
constexpr Lens kUsual{.k1 = 0.3, .k2 = 0.1};  // standard deviations over lenses

// Standard deviations.
constexpr double kShown = 5;   // a coefficient is there, or the focal length is another one
constexpr double kAgrees = 3;  // the focal length may be the one given

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

// Keypoints straightened for `camera` instead of the problem's camera, which becomes it. Returns by how much the
// farthest was shifted, pixels; nothing where a keypoint has no ray, so that no lens is like that.
std::optional<double> straighten(BundleProblem& problem, const Pinhole& camera) {
  double most = 0;
  for (BundleObservation& o : problem.observations) {
    const auto at = camera.straightened(problem.camera.bent({o.u, o.v}));
    if (!at) return std::nullopt;
    most = std::max(most, (*at - Eigen::Vector2d(o.u, o.v)).norm());
    o.u = static_cast<float>(at->x());
    o.v = static_cast<float>(at->y());
  }
  problem.camera = camera;
  return most;
}

bool shows(const LensAdjustment& found) {
  const Lens deviation = found.deviation();
  return std::abs(found.lens.k1) > kShown * deviation.k1 || std::abs(found.lens.k2) > kShown * deviation.k2;
}

// Asks a problem for its lens.
class LensQuestion {
 public:
  LensQuestion(const BundleProblem& problem, const std::atomic<bool>* interrupt)
      : problem_(as_given(problem)), interrupted_([interrupt] { return interrupt && *interrupt; }) {}

  bool interrupted() const { return interrupted_(); }
  // Tells the lens, with the distortion and the focal length free or held; not ok: no answer. The problem as it is
  // then is in `adjusted`.
  LensAdjustment ask(const Lens& begin, const Lens& usual, double usual_focal, BundleProblem& adjusted) const {
    adjusted = problem_;
    return adjust_lens(adjusted, begin, {.usual = usual, .usual_focal = usual_focal, .interrupted = interrupted_});
  }

 private:
  BundleProblem problem_;
  std::function<bool()> interrupted_;
};

}  // namespace

bool refine_distortion(BundleProblem& problem, BundleAdjuster& adjuster, double given_fx,
                       const std::atomic<bool>* interrupt) {
  constexpr double kHeld = 0, kFree = std::numeric_limits<double>::infinity();
  if (problem.poses.size() < kLeastPoses) return false;
  const Pinhole& before = problem.camera;
  const LensQuestion question(problem, interrupt);
  const Lens begin{.focal = given_fx, .k1 = before.residual.k1, .k2 = before.residual.k2};
  BundleProblem adjusted, other;
  LensAdjustment found = question.ask(begin, kUsual, kHeld, adjusted);
  if (!found.ok || !shows(found)) return false;
  found.lens.focal = given_fx;  // to the last digit
  // Another focal length may explain the same, alone or together with a distortion.
  const LensAdjustment plain = question.ask({.focal = before.fx}, {}, kFree, other);
  if (!plain.ok || plain.variance <= found.variance) return false;
  const LensAdjustment free = question.ask(found.lens, kUsual, kFree, other);
  if (!free.ok || question.interrupted()) return false;
  // Another focal length than the given one was taken before. If that was right, a distortion shows all the same while
  // the given one is held, but not once the focal length is free.
  if (before.fx != given_fx && !shows(free)) return false;
  const double off = std::abs(std::log(free.lens.focal / given_fx)) / free.deviation().focal;
  if (off > kShown && shows(free)) {
    found = free;
    adjusted = std::move(other);
  } else if (off > kAgrees) {
    return false;
  }
  if (std::abs(found.lens.focal / given_fx - 1) > kMaxChange) return false;

  Pinhole camera = before;
  camera.fx = found.lens.focal;
  camera.fy = before.fy / before.fx * camera.fx;
  camera.residual = {found.lens.k1, found.lens.k2};
  restore_scale(0, distances_from(0, problem), adjusted);
  BundleProblem moved = problem;
  moved.poses = std::move(adjusted.poses);
  moved.points = std::move(adjusted.points);
  const auto shift = straighten(moved, camera);
  if (!shift || (*shift < kLeastShift && camera.fx == before.fx)) return false;
  const BundleSummary summary = adjuster.solve(moved, {.iterations = 20, .interrupt = interrupt});
  if (!summary.ok || summary.interrupted) return false;
  classify_observations(moved);
  problem = std::move(moved);
  return true;
}

}  // namespace covis
