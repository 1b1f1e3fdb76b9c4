// SPDX-License-Identifier: Apache-2.0
#include "covis/loops/camera_refinement.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "covis/core/log.h"
#include "covis/loops/distortion_refinement.h"
#include "covis/loops/submap_adjustment.h"
#include "covis/map/camera_change.h"
#include "covis/optimization/focal_estimation.h"

namespace covis {

// Not asked while there are several submaps, which all would have to follow, nor when another camera made some key
// frames, whose keypoints were expressed in this one's focal length.
std::optional<int> RefinementSchedule::ask(const Map& map) {
  if (map.next_serial() < next_ || map.key_frame_count() > pace_.largest || map.submaps().size() != 1 ||
      has_other_cameras(map))
    return std::nullopt;
  next_ = map.next_serial() + std::max(kLeastStep, static_cast<uint32_t>(pace_.more * map.next_serial()));
  return kLeastAge + static_cast<int>(map.key_frame_count()) / kAgeShare;
}

namespace {

// One step; false: the problem stays as it was.
bool step(BundleProblem& problem, BundleAdjuster& adjuster, double given_fx, const std::atomic<bool>* interrupt) {
  constexpr double kMaxSigma = 0.005;   // standard deviation of the factor: it is known well
  constexpr double kMinChange = 0.006;  // worth it …
  constexpr double kSignificant = 8;    // … and so many sigmas, as if errors were independent …
  constexpr double kScattered = 2.5;    // … and so many of those by which pieces of the map scatter
  constexpr double kMaxStep = 0.02;     // twice as far as the estimate looks: the next step goes on from there
  constexpr double kMaxChange = 0.05;   // as a share of the one given
  const FocalEstimate estimate = estimate_focal(problem, adjuster, interrupt);
  if (!estimate.ok || estimate.sigma > kMaxSigma) return false;
  const double least = std::max({kMinChange, kSignificant * estimate.sigma, kScattered * estimate.scatter});
  if (std::abs(estimate.factor - 1) < least || !estimate.agreed) return false;
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

std::unique_ptr<CameraRefinement> CameraRefinement::of(const Map& map, KeyFrameId key_frame,
                                                       const RefinableCamera& refinable) {
  std::optional<MapProblem> submap = copy_submap(map, key_frame);
  if (!submap) return nullptr;
  return std::unique_ptr<CameraRefinement>(new CameraRefinement(std::move(*submap), refinable));
}

bool CameraRefinement::run(const std::atomic<bool>& interrupt) {
  constexpr int kIterations = 20;  // before the camera is asked for
  BundleAdjuster adjuster;
  BundleProblem& problem = submap_.problem;
  const bool solved = adjuster.solve(problem, {.iterations = kIterations, .interrupt = &interrupt}).ok;
  classify_observations(problem);
  if (!solved) return false;
  if (refinable_.distortion && refine_distortion(problem, adjuster, refinable_.given_fx, &interrupt)) return true;
  // With the distortion found goes the given focal length.
  if (!refinable_.focal || problem.camera.residual.any()) return false;
  return refine_focal(problem, adjuster, refinable_.given_fx, &interrupt);
}

std::optional<KeyFrameMoves> CameraRefinement::apply(SharedMap& map) const {
  Pinhole camera = submap_.problem.camera;
  bool alone = false;
  {
    const auto present = map.read();
    camera.depth_noise = present->camera().depth_noise;  // may have been estimated anew since
    alone = present->submaps().size() == 1;
  }
  if (!alone) return std::nullopt;
  auto moves = apply_submap(submap_, map, camera);
  if (!moves) return std::nullopt;
  const ResidualDistortion& residual = camera.residual;
  log(LogLevel::info, residual.any() ? "distortion found that the camera was given without: k1 " +
                                           std::to_string(residual.k1) + ", k2 " + std::to_string(residual.k2)
                                     : "focal length refined: " + std::to_string(camera.fx) + " pixels instead of " +
                                           std::to_string(refinable_.given_fx));
  return moves;
}

}  // namespace covis
