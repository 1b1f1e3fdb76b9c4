// SPDX-License-Identifier: Apache-2.0
#include "covis/optimization/focal_estimation.h"

#include <gtest/gtest.h>

#include <cmath>

#include "covis/core/random.h"
#include "covis/geometry/lie.h"

namespace covis {
namespace {

constexpr int kCameras = 16;
constexpr double kNoise = 0.3;  // pixels

// A camera that moves forward and turns by `turn` radians in all, among points seen with some noise by a camera of
// focal length 500; the problem's camera has `claimed` times that.
BundleProblem drive(double turn, double claimed, uint64_t seed) {
  const Pinhole truth{500, 500, 320, 240, 0};
  Random random(seed);
  BundleProblem problem;
  problem.camera = with_focal(truth, claimed);
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  std::vector<SE3> T_wc;
  for (int k = 0; k < kCameras; ++k) {
    const double yaw = turn * k / (kCameras - 1);
    const SE3 rotation = SE3::exp((Vector6d() << 0, 0, 0, 0, yaw, 0).finished());
    T_wc.emplace_back(rotation.R(), centre);
    centre += rotation.R() * Eigen::Vector3d(0, 0, 0.5);
    problem.poses.push_back(T_wc.back().inverse());
    problem.fixed.push_back(k == 0);
  }
  for (int p = 0; p < 800; ++p) {
    const SE3& from = T_wc[static_cast<size_t>(p % kCameras)];
    const Eigen::Vector3d place =
        from * Eigen::Vector3d(random.uniform(-4, 4), random.uniform(-3, 3), random.uniform(4, 14));
    std::vector<BundleObservation> seen;
    for (int k = 0; k < kCameras; ++k) {
      const Eigen::Vector3d p_c = problem.poses[static_cast<size_t>(k)] * place;
      if (p_c.z() < 1) continue;
      const Eigen::Vector2d pixel = truth.project(p_c);
      if (pixel.x() < 0 || pixel.y() < 0 || pixel.x() >= 640 || pixel.y() >= 480) continue;
      // Uniform, of standard deviation kNoise.
      const double width = kNoise * std::sqrt(3.0);
      seen.push_back({.pose = k,
                      .point = static_cast<int32_t>(problem.points.size()),
                      .u = static_cast<float>(pixel.x() + random.uniform(-width, width)),
                      .v = static_cast<float>(pixel.y() + random.uniform(-width, width))});
    }
    if (seen.size() < 3) continue;
    problem.points.push_back(place);
    problem.observations.insert(problem.observations.end(), seen.begin(), seen.end());
  }
  return problem;
}

FocalEstimate estimate(BundleProblem problem) {
  BundleAdjuster adjuster;
  adjuster.solve(problem, {.iterations = 30});
  classify_observations(problem);
  return estimate_focal(problem, adjuster);
}

TEST(FocalEstimation, FindsTheFocalLengthOfACameraThatTurns) {
  for (uint64_t seed = 1; seed <= 3; ++seed) {
    for (const double claimed : {0.98, 0.99, 1.0, 1.01, 1.02}) {
      const FocalEstimate e = estimate(drive(0.8, claimed, seed));
      ASSERT_TRUE(e.ok);
      EXPECT_LT(e.sigma, 0.003);
      EXPECT_NEAR(e.factor * claimed, 1, 4 * e.sigma + 0.001) << "claimed " << claimed << " seed " << seed;
    }
  }
}

// Errors that are one in each half of the drive, as of a scale that drifts: the parts contradict each other.
TEST(FocalEstimation, ErrorsThatAreAlikeAreCounted) {
  BundleProblem problem = drive(0.8, 1, 1);
  const FocalEstimate independent = estimate(problem);
  for (BundleObservation& o : problem.observations) {
    const auto stretch = static_cast<float>(o.pose < kCameras / 2 ? 1.01 : 0.99);
    o.u = 320 + stretch * (o.u - 320);
    o.v = 240 + stretch * (o.v - 240);
  }
  const FocalEstimate alike = estimate(problem);
  ASSERT_TRUE(independent.ok && alike.ok);
  EXPECT_LT(independent.scatter, 2 * independent.sigma);
  EXPECT_GT(alike.scatter, 2 * independent.scatter);
}

// Beside outlines a depth is another thing's. The adjustment bounds what it costs, and so does what each part of it
// says.
TEST(FocalEstimation, WrongDepthsMakeNoPartContradict) {
  BundleProblem problem = drive(0.8, 1, 1);
  problem.camera.bf = 40;
  problem.camera.depth_noise = {0.002, 0.002};
  Random random(1);
  for (BundleObservation& o : problem.observations) {
    const Eigen::Vector3d p_c =
        problem.poses[static_cast<size_t>(o.pose)] * problem.points[static_cast<size_t>(o.point)];
    const double factor = random.below(50) == 0 ? 1.5 : 1 + 0.002 * random.normal();
    o.disparity = disparity_of_depth(problem.camera, static_cast<float>(factor * p_c.z()), o.inv_sigma2);
  }
  const FocalEstimate found = estimate(problem);
  ASSERT_TRUE(found.ok);
  EXPECT_NEAR(found.factor, 1, 0.003);
  EXPECT_LT(found.scatter, 0.002);
}

TEST(FocalEstimation, BothAxesAgreeWhereTheFocalLengthAloneIsWrong) {
  // The camera is held askew by 45 degrees, so that its turns tell as much in rows as in columns.
  BundleProblem problem = drive(0.8, 1.02, 1);
  const double half = std::sqrt(0.5);
  const SE3 askew(so3_exp({0, 0, std::asin(half)}), Eigen::Vector3d::Zero());
  for (SE3& pose : problem.poses) pose = askew * pose;
  for (BundleObservation& o : problem.observations) {
    const double u = o.u - 320, v = o.v - 240;
    o.u = static_cast<float>(320 + half * (u - v));
    o.v = static_cast<float>(240 + half * (u + v));
  }
  EXPECT_TRUE(estimate(problem).agreed);
}

TEST(FocalEstimation, MoreTurningTellsMore) {
  const FocalEstimate little = estimate(drive(0.3, 1, 1)), much = estimate(drive(1.0, 1, 1));
  ASSERT_TRUE(little.ok && much.ok);
  EXPECT_LT(much.sigma, 0.5 * little.sigma);
}

TEST(FocalEstimation, StraightAheadItIsNotSure) {
  for (uint64_t seed = 1; seed <= 3; ++seed) {
    const FocalEstimate e = estimate(drive(0, 1.02, seed));
    EXPECT_TRUE(!e.ok || e.sigma > 0.005) << e.sigma;
  }
}

TEST(FocalEstimation, LeavesTheProblemAndStopsWhenTold) {
  const BundleProblem problem = drive(0.8, 1.02, 1);
  BundleAdjuster adjuster;
  const std::atomic<bool> stop{true};
  EXPECT_FALSE(estimate_focal(problem, adjuster, &stop).ok);
  EXPECT_FALSE(estimate_focal({}, adjuster).ok);
  const FocalEstimate once = estimate_focal(problem, adjuster), again = estimate_focal(problem, adjuster);
  EXPECT_EQ(once.factor, again.factor);
  EXPECT_EQ(once.sigma, again.sigma);
}

}  // namespace
}  // namespace covis
