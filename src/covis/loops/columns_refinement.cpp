// SPDX-License-Identifier: Apache-2.0
#include "covis/loops/columns_refinement.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "covis/core/log.h"
#include "covis/loops/submap_adjustment.h"
#include "covis/optimization/columns_estimation.h"

namespace covis {
namespace {

// Root mean square over disparities, pixels.
double shift_of(const BundleProblem& problem) {
  const Pinhole& camera = problem.camera;
  double sum = 0;
  int measured = 0;
  for (const BundleObservation& o : problem.observations) {
    if (!o.disparity.measured()) continue;
    const double u = static_cast<double>(o.u - o.disparity.pixels);
    const double shift = u - camera.rectified_column(u, static_cast<double>(o.v));
    sum += shift * shift;
    ++measured;
  }
  return std::sqrt(sum / std::max(measured, 1));
}

}  // namespace

bool refine_columns(BundleProblem& problem, BundleAdjuster& adjuster, double deviations,
                    const std::atomic<bool>* interrupt) {
  constexpr double kLeastShift = 0.1, kLeastChange = 0.02;  // pixels, root mean square over observations
  constexpr double kMostNoise = 0.08;  // pixels: where motion tells less, biases of matching take the field's place
  const std::optional<ColumnsEstimate> estimate = estimate_columns(problem, adjuster, interrupt);
  if (!estimate) return false;
  // More key frames know it better than fewer did.
  const double least =
      problem.camera.right_columns.any() ? kLeastChange : std::max(kLeastShift, deviations * estimate->noise);
  if (estimate->size < least || estimate->noise > kMostNoise) return false;
  BundleProblem moved = problem;
  if (!take_out(estimate->field, moved)) return false;
  const BundleSummary summary = adjuster.solve(moved, {.iterations = 20, .interrupt = interrupt});
  if (!summary.ok || summary.interrupted) return false;
  classify_observations(moved);
  problem = std::move(moved);
  return true;
}

std::unique_ptr<ColumnsRefinement> ColumnsRefinement::of(const Map& map, KeyFrameId key_frame) {
  std::optional<MapProblem> submap = copy_submap(map, key_frame);
  if (!submap) return nullptr;
  const bool rows_are_off = map.at(key_frame).features->right_rows_are_off;
  return std::unique_ptr<ColumnsRefinement>(new ColumnsRefinement(std::move(*submap), rows_are_off));
}

bool ColumnsRefinement::run(const std::atomic<bool>& interrupt) {
  BundleAdjuster adjuster;
  BundleProblem& problem = submap_.problem;
  const bool solved = adjuster.solve(problem, {.iterations = 20, .interrupt = &interrupt}).ok;
  classify_observations(problem);
  // A pair whose rows are off is not rectified, so that less shows its columns.
  constexpr double kShown = 5, kShownBesideRows = 3;  // standard deviations
  return solved && refine_columns(problem, adjuster, rows_are_off_ ? kShownBesideRows : kShown, &interrupt);
}

std::optional<KeyFrameMoves> ColumnsRefinement::apply(SharedMap& map) const {
  if (map.read()->submaps().size() != 1) return std::nullopt;
  auto moves = apply_submap(submap_, map, submap_.problem.camera);
  if (!moves) return std::nullopt;
  log(LogLevel::info, "the right image's columns are not rectified: by " + std::to_string(shift_of(submap_.problem)) +
                          " pixels (root mean square), taken out of all disparities");
  return moves;
}

}  // namespace covis
