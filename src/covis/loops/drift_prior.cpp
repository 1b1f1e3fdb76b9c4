// SPDX-License-Identifier: Apache-2.0
#include "covis/loops/drift_prior.h"

#include <Eigen/Cholesky>

namespace covis {

Sim3 weigh_against_drift(const Sim3& correction, const Matrix7d& information, const ExpectedDrift& drift) {
  // Measured in the note. The standard deviation of the drift, as a share of how far the scene moved past; and that of
  // the logarithm of the scale, in those of the angle.
  constexpr double kShare = 0.002, kScale = 2;
  // The standard deviation of what the points say, in that by the noise of the pixels. It covers errors that many of
  // them share.
  constexpr double kPointErrors = 18;
  constexpr double kAlmost = 1.01;
  constexpr int kRounds = 30;
  if (!(drift.past > 0) || !(drift.depth > 0)) return correction;
  const double sigma = kShare * drift.past, angle = sigma / drift.depth;
  Vector7d sigmas;
  sigmas << Eigen::Vector3d::Constant(sigma), Eigen::Vector3d::Constant(angle), kScale * angle;
  const int unknowns = drift.scale == Scale::free ? 7 : 6;
  const Vector7d measured = correction.log();
  // Both as information of the logarithm of the correction.
  const Matrix7d J = Sim3::left_jacobian(measured);
  const Matrix7d of_points = J.transpose() * information * J / (kPointErrors * kPointErrors);
  Matrix7d of_drift = sigmas.cwiseAbs2().cwiseInverse().asDiagonal();
  Vector7d weighed = measured;
  // The variance of the drift rises in each round towards the only one at which the excess is 1. How near it comes
  // matters little: it decides about directions that the points determine as little.
  for (int round = 0; round < kRounds; ++round) {
    weighed = (of_points + of_drift).ldlt().solve(of_points * measured);
    if (!weighed.allFinite()) return correction;
    // The mean squared correction, in units of the variance that is expected of drift and points together.
    const double excess = measured.dot(of_drift * weighed) / unknowns;
    if (excess < kAlmost) break;
    of_drift /= excess;
  }
  if (drift.scale == Scale::fixed) weighed(6) = 0;  // rounding
  return Sim3::exp(weighed);
}

}  // namespace covis
