// SPDX-License-Identifier: Apache-2.0
#include "covis/optimization/columns_estimation.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "covis/geometry/alike_errors.h"
#include "covis/geometry/field_estimate.h"
#include "covis/geometry/measurement.h"
#include "covis/optimization/reprojection.h"

namespace covis {
namespace {

using Vector = FieldEstimate::Vector;
using Matrix = FieldEstimate::Matrix;

Vector terms_of(const Pinhole& camera, const BundleObservation& o) {
  const double u = static_cast<double>(o.u - o.disparity.pixels), v = static_cast<double>(o.v);
  return FieldEstimate::vector(ShiftField::terms((u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy));
}

using Residuals = std::vector<Eigen::Vector3d>;

// Those of the active observations, divided by their sigmas; zero for the others.
Residuals residuals(const BundleProblem& problem) {
  Residuals made(problem.observations.size(), Eigen::Vector3d::Zero());
  for (size_t k = 0; k < made.size(); ++k) {
    const BundleObservation& o = problem.observations[k];
    if (!o.active) continue;
    const Eigen::Vector3d p_c =
        problem.poses[static_cast<size_t>(o.pose)] * problem.points[static_cast<size_t>(o.point)];
    const double pixel = std::sqrt(static_cast<double>(o.inv_sigma2));
    const double disparity = std::sqrt(static_cast<double>(o.disparity.inv_sigma2));
    made[k] = reprojection_residual(p_c, problem.camera, o.u, o.v, o.disparity)
                  .cwiseProduct(Eigen::Vector3d(pixel, pixel, disparity));
  }
  return made;
}

// Adjusts the problem until convergence, without robust weights. False: interrupted.
bool converge(BundleProblem& problem, BundleAdjuster& adjuster, const std::atomic<bool>* interrupt) {
  const BundleSummary summary = adjuster.solve(
      problem, {.iterations = 40, .robust = false, .relative_cost_change = 1e-9, .interrupt = interrupt});
  return summary.ok && !summary.interrupted;
}

}  // namespace

std::optional<ColumnsEstimate> estimate_columns(const BundleProblem& problem, BundleAdjuster& adjuster,
                                                const std::atomic<bool>* interrupt) {
  constexpr double kStep = 0.1;  // pixels
  const size_t n = problem.observations.size();
  std::vector<Vector> terms;
  terms.reserve(n);
  Matrix places = Matrix::Zero();
  size_t measured = 0;
  for (const BundleObservation& o : problem.observations) {
    terms.push_back(terms_of(problem.camera, o));
    if (!o.active || !o.disparity.measured()) continue;
    places += terms.back() * terms.back().transpose();
    ++measured;
  }
  const double freedom = degrees_of_freedom(problem);
  if (measured == 0 || !(freedom > 0)) return std::nullopt;
  places /= static_cast<double>(measured);

  BundleProblem adjusted = problem;
  if (!converge(adjusted, adjuster, interrupt)) return std::nullopt;
  const Residuals before = residuals(adjusted);
  std::vector<Eigen::Matrix<float, 3, FieldEstimate::kTerms>> changes(n);  // by a pixel of each term
  for (int term = 0; term < FieldEstimate::kTerms; ++term) {
    BundleProblem moved = adjusted;
    for (size_t k = 0; k < n; ++k) {
      Disparity& d = moved.observations[k].disparity;
      if (d.measured()) d.pixels = std::max(kLeastDisparity, d.pixels + static_cast<float>(kStep * terms[k][term]));
    }
    if (!converge(moved, adjuster, interrupt)) return std::nullopt;
    const Residuals after = residuals(moved);
    for (size_t k = 0; k < n; ++k) changes[k].col(term) = ((after[k] - before[k]) / kStep).cast<float>();
  }

  FieldEstimate estimate;
  double variance = 0;
  for (size_t k = 0; k < n; ++k) {
    const Eigen::Matrix<double, 3, FieldEstimate::kTerms> change = changes[k].cast<double>();
    estimate.H += change.transpose() * change;
    estimate.b -= change.transpose() * before[k];
    variance += before[k].squaredNorm() / freedom;
  }
  if (!estimate.solve()) return std::nullopt;
  std::vector<Vector> left(problem.poses.size(), Vector::Zero());
  for (size_t k = 0; k < n; ++k) {
    const Eigen::Matrix<double, 3, FieldEstimate::kTerms> change = changes[k].cast<double>();
    left[static_cast<size_t>(problem.observations[k].pose)] +=
        change.transpose() * (before[k] + change * FieldEstimate::vector(estimate.field.pixels));
  }
  ColumnsEstimate made{.field = estimate.field, .size = estimate.size(places)};
  const Matrix inverse = estimate.inverse();
  double noise2 = (variance * inverse * places).trace();
  for (const size_t pieces : kNumbersOfPieces)
    noise2 = std::max(noise2, (covariance_of_parts(inverse, sums_over_pieces(left, pieces)) * places).trace());
  made.noise = std::sqrt(noise2);
  if (!std::isfinite(made.size) || !std::isfinite(made.noise)) return std::nullopt;
  return made;
}

bool take_out(const ShiftField& field, BundleProblem& problem) {
  BundleProblem moved = problem;
  for (BundleObservation& o : moved.observations) {
    if (!o.disparity.measured()) continue;
    const double shift = FieldEstimate::vector(field.pixels).dot(terms_of(problem.camera, o));
    if (!(std::abs(shift) < kMostRectificationError)) return false;
    o.disparity.pixels = std::max(kLeastDisparity, o.disparity.pixels + static_cast<float>(shift));
  }
  moved.camera.right_columns = moved.camera.right_columns + field;
  problem = std::move(moved);
  return true;
}

}  // namespace covis
