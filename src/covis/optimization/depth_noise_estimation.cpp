// SPDX-License-Identifier: Apache-2.0
#include "covis/optimization/depth_noise_estimation.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace covis {
namespace {

// Squares, relative to the depth.
struct DepthError {
  double error = 0;     // error of a depth
  double sensor = 0;    // variance of the sensor, by the model
  double position = 0;  // variance by the position of the keypoint
};

constexpr int kLeastDepths = 3;  // depths of one point

std::vector<DepthError> depth_errors(const BundleProblem& problem) {
  const Pinhole& camera = problem.camera;
  const auto tells = [](const BundleObservation& o) { return o.active && o.disparity.measured(); };
  std::vector<int> depths(problem.points.size(), 0);
  for (const BundleObservation& o : problem.observations) depths[static_cast<size_t>(o.point)] += tells(o);
  std::vector<DepthError> errors;
  for (const BundleObservation& o : problem.observations) {
    const auto p = static_cast<size_t>(o.point);
    if (!tells(o) || depths[p] < kLeastDepths) continue;
    const double z = (problem.poses[static_cast<size_t>(o.pose)] * problem.points[p]).z();
    const double measured = camera.bf / static_cast<double>(o.disparity.pixels);
    // The point is the mean of its depths where nothing else tells it, and so nearer to them than the truth is.
    const double own_share = depths[p] / (depths[p] - 1.0);
    const double relative = measured / z - 1, sensor = camera.depth_noise.sigma(measured) / measured;
    errors.push_back(
        {relative * relative * own_share, sensor * sensor, relative_position_variance(camera, o.inv_sigma2)});
  }
  return errors;
}

}  // namespace

std::optional<double> depth_noise_factor(const BundleProblem& problem) {
  constexpr size_t kLeast = 100, kMost = 2000;  // depths
  constexpr double kMedian = 0.4549;            // median of a chi-square distribution of one degree of freedom
  constexpr int kSteps = 16;
  if (!problem.camera.depth_noise.known()) return std::nullopt;
  const std::vector<DepthError> errors = depth_errors(problem);
  if (errors.size() < kLeast) return std::nullopt;
  const size_t stride = (errors.size() + kMost - 1) / kMost;
  std::vector<double> chi2;
  // The median falls as the factor rises: bisection of the factor's logarithm.
  double low = -4, high = 4;
  for (int step = 0; step < kSteps; ++step) {
    const double middle = (low + high) / 2, square = std::exp(2 * middle);
    chi2.clear();
    for (size_t k = 0; k < errors.size(); k += stride)
      chi2.push_back(errors[k].error / (square * errors[k].sensor + errors[k].position));
    const auto at = chi2.begin() + static_cast<ptrdiff_t>(chi2.size() / 2);
    std::nth_element(chi2.begin(), at, chi2.end());
    (*at > kMedian ? low : high) = middle;
  }
  return std::exp((low + high) / 2);
}

}  // namespace covis
