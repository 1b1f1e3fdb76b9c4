// SPDX-License-Identifier: Apache-2.0
// For tests: points seen by a pair that moves ahead, and whose right image shows them in columns that are off.
#pragma once

#include <cstdint>
#include <vector>

#include "covis/core/random.h"
#include "covis/geometry/measurement.h"
#include "covis/optimization/bundle_adjustment.h"

namespace covis::pair_test {

inline constexpr Pinhole kPair{.fx = 500, .fy = 500, .cx = 320, .cy = 240, .bf = 150};

// The column of the right image in which a pair of that error shows what one without shows at u.
inline double shown_column(const ShiftField& off, double u, double v) {
  return u + off.at((u - kPair.cx) / kPair.fx, (v - kPair.cy) / kPair.fy);
}

inline BundleProblem pair_problem(const ShiftField& off, uint64_t seed) {
  constexpr int kViews = 12, kPoints = 700;
  constexpr double kNoise = 0.3;  // pixels
  Random random(seed);
  BundleProblem problem;
  problem.camera = kPair;
  for (int k = 0; k < kViews; ++k) {
    problem.poses.push_back(SE3::exp((Vector6d() << 0.05 * k, 0, -0.5 * k, 0, 0.01 * k, 0).finished()));
    problem.fixed.push_back(k == 0);
  }
  for (int p = 0; p < kPoints; ++p) {
    const Eigen::Vector3d place(random.uniform(-8, 8), random.uniform(-5, 5), random.uniform(4, 30));
    std::vector<BundleObservation> seen;
    for (int k = 0; k < kViews; ++k) {
      const Eigen::Vector3d p_c = problem.poses[static_cast<size_t>(k)] * place;
      if (p_c.z() < 2) continue;
      const PredictedMeasurement m = predict_measurement(p_c, kPair);
      if (m.u < 0 || m.v < 0 || m.u >= 640 || m.v >= 480) continue;
      const double u = m.u + kNoise * random.normal(), v = m.v + kNoise * random.normal();
      const double right = m.u - m.disparity + kNoise * random.normal();
      const auto disparity = static_cast<float>(u - shown_column(off, right, v));
      if (!(disparity > 0.5f)) continue;
      seen.push_back({.pose = k,
                      .point = static_cast<int32_t>(problem.points.size()),
                      .u = static_cast<float>(u),
                      .v = static_cast<float>(v),
                      .disparity = {disparity, 1}});
    }
    if (seen.size() < 3) continue;
    problem.points.push_back(place);
    problem.observations.insert(problem.observations.end(), seen.begin(), seen.end());
  }
  return problem;
}

}  // namespace covis::pair_test
