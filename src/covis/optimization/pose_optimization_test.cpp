// SPDX-License-Identifier: Apache-2.0
#include "covis/optimization/pose_optimization.h"

#include <gtest/gtest.h>

#include <limits>
#include <vector>

#include "covis/core/test_allocations.h"
#include "tests/ceres_problems.h"

namespace covis {
namespace {

struct PoseCase {
  PoseObservations observations;
  SE3 truth, start;
};

PoseCase make_pose_case(uint64_t seed, int count, double outliers, Rows rows) {
  Random random(seed);
  PoseCase c;
  c.truth = random_pose(random, 0.5, 1);
  c.start = random_pose(random, 0.12, 0.2) * c.truth;
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector3d p_c(random.uniform(-2, 2), random.uniform(-1.5, 1.5), random.uniform(2, 8));
    const Eigen::Vector2d pixel = kCamera.project(p_c);
    const bool wrong = random.uniform() < outliers, stereo = rows == Rows::stereo || (rows == Rows::mixed && i % 2);
    const double u = pixel.x() + (wrong ? random.uniform(-100, 100) : 0.7 * random.normal()),
                 v = pixel.y() + (wrong ? random.uniform(-100, 100) : 0.7 * random.normal());
    const double right = pixel.x() - kCamera.bf / p_c.z() + 0.7 * random.normal(), disparity = u - right;
    c.observations.add(c.truth.inverse() * p_c, static_cast<float>(u), static_cast<float>(v), 1,
                       {stereo ? static_cast<float>(std::max(0.0, disparity)) : 0, 1});
  }
  return c;
}

TEST(PoseOptimization, EndsWhereCeresEnds) {
  for (const Rows rows : {Rows::mono, Rows::stereo, Rows::mixed}) {
    for (uint64_t seed = 1; seed <= 8; ++seed) {
      const PoseCase c = make_pose_case(seed, 200, 0.2, rows);
      std::vector<uint8_t> inlier;
      const PoseResult result =
          optimize_pose(c.start, c.observations, kCamera, {.rounds = 6, .iterations = 30}, inlier);
      ASSERT_TRUE(result.ok);
      CeresPose pose(result.T_cw);
      ceres::Problem theirs;
      std::vector<Eigen::Vector3d> points;
      for (size_t i = 0; i < inlier.size(); ++i)
        points.emplace_back(c.observations.px[i], c.observations.py[i], c.observations.pz[i]);
      for (size_t i = 0; i < inlier.size(); ++i) {
        if (!inlier[i]) continue;
        theirs.AddResidualBlock(make_cost(c.observations.u[i], c.observations.v[i], 1, c.observations.disparity[i]),
                                nullptr, pose.v, points[i].data());
        theirs.SetParameterBlockConstant(points[i].data());
      }
      ceres::Solver::Options options;
      options.function_tolerance = options.gradient_tolerance = options.parameter_tolerance = 1e-15;
      options.logging_type = ceres::SILENT;
      ceres::Solver::Summary summary;
      ceres::Solve(options, &theirs, &summary);
      EXPECT_LE(result.cost, 2 * summary.final_cost * (1 + 1e-6)) << "seed " << seed;
      EXPECT_LT((result.T_cw * c.truth.inverse()).log().norm(), 0.02);
    }
  }
}

// A depth sensor's depth adds what the derivative of its disparity by the pose says, taken numerically here.
TEST(PoseOptimization, DepthsOfASensorWeighByTheirOwnVariance) {
  constexpr float kInvSigma2 = 25;
  Pinhole camera = kCamera;
  camera.depth_noise = DepthNoise::kinect();
  Random random(4);
  const SE3 truth = random_pose(random, 0.5, 1);
  PoseObservations with, without;
  Matrix6d expected = Matrix6d::Zero();
  for (int i = 0; i < 60; ++i) {
    const Eigen::Vector3d p_c(random.uniform(-2, 2), random.uniform(-1.5, 1.5), random.uniform(2, 8));
    const Eigen::Vector3d p_w = truth.inverse() * p_c;
    const Eigen::Vector2d pixel = camera.project(p_c);
    const auto u = static_cast<float>(pixel.x()), v = static_cast<float>(pixel.y());
    without.add(p_w, u, v, 1, {});
    with.add(p_w, u, v, 1, {static_cast<float>(camera.bf / p_c.z()), kInvSigma2});
    Vector6d J;
    for (int k = 0; k < 6; ++k) {
      constexpr double kStep = 1e-6;
      const auto disparity = [&](double step) {
        Vector6d xi = Vector6d::Zero();
        xi[k] = step;
        return camera.bf / (SE3::exp(xi) * p_c).z();
      };
      J[k] = (disparity(kStep) - disparity(-kStep)) / (2 * kStep);
    }
    expected += static_cast<double>(kInvSigma2) * J * J.transpose();
  }
  std::vector<uint8_t> inlier;
  const PoseResult a = optimize_pose(truth, with, camera, {}, inlier);
  const PoseResult b = optimize_pose(truth, without, camera, {}, inlier);
  ASSERT_TRUE(a.ok && b.ok);
  EXPECT_LT((a.information - b.information - expected).norm(), 1e-3 * expected.norm());
}

TEST(PoseOptimization, StandsOutliersAndFewObservations) {
  int good = 0;
  for (uint64_t seed = 1; seed <= 50; ++seed) {
    const PoseCase many = make_pose_case(seed, 150, 0.4, Rows::stereo), few = make_pose_case(seed, 15, 0, Rows::mono);
    std::vector<uint8_t> inlier;
    const PoseResult a = optimize_pose(many.start, many.observations, kCamera, {}, inlier);
    good += a.ok && (a.T_cw * many.truth.inverse()).log().norm() < 0.02;
    const PoseResult b = optimize_pose(few.start, few.observations, kCamera, {}, inlier);
    good += b.ok && (b.T_cw * few.truth.inverse()).log().norm() < 0.1;
  }
  EXPECT_GE(good, 96);
}

TEST(PoseOptimization, BadObservationsDoNotPoisonIt) {
  PoseCase c = make_pose_case(3, 60, 0, Rows::mixed);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  c.observations.add({0, 0, 5}, nan, 0, 1);
  c.observations.add({nan, 0, 5}, 0, 0, 1);
  c.observations.add(c.truth.inverse() * Eigen::Vector3d(0, 0, -3), 320, 240, 1);  // behind
  std::vector<uint8_t> inlier;
  const PoseResult result = optimize_pose(c.start, c.observations, kCamera, {}, inlier);
  ASSERT_TRUE(result.ok);
  EXPECT_TRUE(result.T_cw.all_finite());
  EXPECT_GE(result.inliers, 50);
  for (size_t i = 60; i < 63; ++i) EXPECT_FALSE(inlier[i]);
  PoseObservations none;
  EXPECT_FALSE(optimize_pose(SE3(), none, kCamera, {}, inlier).ok);
}

// The error's square by the information: of 6 degrees of freedom, and pixels of 0.7 instead of 1.
TEST(PoseOptimization, ItsInformationTellsItsErrors) {
  for (const Rows rows : {Rows::mono, Rows::stereo}) {
    double sum = 0;
    constexpr int kSeeds = 200;
    for (uint64_t seed = 1; seed <= kSeeds; ++seed) {
      const PoseCase c = make_pose_case(seed, 60, 0, rows);
      std::vector<uint8_t> inlier;
      const PoseResult result = optimize_pose(c.start, c.observations, kCamera, {}, inlier);
      ASSERT_TRUE(result.ok);
      const Vector6d error = (result.T_cw * c.truth.inverse()).log();
      sum += error.dot(result.information * error);
    }
    EXPECT_NEAR(sum / kSeeds, 6 * 0.49, 0.6);
  }
}

// A wall, and before it something near that goes with the camera: known as it was a moment ago, 5 cm nearer, it seems
// to say that the camera stands.
PoseObservations wall_behind_something(const Pinhole& camera, bool near_ones_lead) {
  Random random(7);
  PoseObservations observations;
  const SE3 truth_wc(Eigen::Matrix3d::Identity(), {0, 0, 0.05});
  for (int i = 0; i < 200; ++i) {
    const bool moves = i % 3 == 0;
    const double z = moves ? 1.2 : random.uniform(4, 7);
    const Eigen::Vector3d p_c(z * random.uniform(-0.1, 0.1) * (moves ? 1 : 4),
                              z * random.uniform(-0.1, 0.1) * (moves ? 1 : 4), z);
    const Eigen::Vector2d pixel = camera.project(p_c);
    const Disparity disparity = disparity_of_depth(camera, static_cast<float>(z), 1);
    observations.add(moves ? p_c : truth_wc * p_c, static_cast<float>(pixel.x() + 0.3 * random.normal()),
                     static_cast<float>(pixel.y() + 0.3 * random.normal()), 1, disparity, near_ones_lead || !moves);
  }
  return observations;
}

TEST(PoseOptimization, PreciseDepthsOfAFewDoNotOutvoteTheRest) {
  Pinhole camera = kCamera;
  camera.depth_noise = {0.002, 0.002};
  for (const bool lead : {true, false}) {
    const PoseObservations observations = wall_behind_something(camera, lead);
    std::vector<uint8_t> inlier;
    const PoseResult result = optimize_pose(SE3(), observations, camera, {}, inlier);
    ASSERT_TRUE(result.ok);
    EXPECT_LT((result.T_cw.centre() - Eigen::Vector3d(0, 0, 0.05)).norm(), lead ? 0.025 : 0.012);
  }
}

TEST(PoseOptimization, WhatDoesNotLeadDoesNotMoveThePose) {
  PoseCase c = make_pose_case(9, 200, 0, Rows::mono);
  for (size_t i = 0; i < 200; ++i) {
    const bool moves = i % 10 < 7;
    c.observations.leads[i] = !moves;
    if (moves) c.observations.u[i] += 12;
  }
  std::vector<uint8_t> inlier;
  const PoseResult result = optimize_pose(c.start, c.observations, kCamera, {}, inlier);
  ASSERT_TRUE(result.ok);
  EXPECT_LT((result.T_cw * c.truth.inverse()).log().norm(), 0.01);
  EXPECT_GE(result.inliers, 55);
  EXPECT_LE(result.inliers, 60);
}

TEST(PoseOptimization, AllocatesNothing) {
  const PoseCase c = make_pose_case(4, 300, 0.2, Rows::mixed);
  std::vector<uint8_t> inlier(300);
  const long before = all_allocations;
  const PoseResult result = optimize_pose(c.start, c.observations, kCamera, {}, inlier);
  EXPECT_EQ(all_allocations, before);
  EXPECT_TRUE(result.ok);
}

}  // namespace
}  // namespace covis
