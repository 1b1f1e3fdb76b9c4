// SPDX-License-Identifier: Apache-2.0
#include <ceres/ceres.h>
#include <ceres/rotation.h>
#include <gtest/gtest.h>

#include "covis/core/random.h"
#include "covis/core/test_allocations.h"
#include "covis/optimization/bundle_adjustment.h"
#include "covis/optimization/pose_optimization.h"
#include "covis/optimization/reprojection.h"

namespace covis {
namespace {

const Pinhole kCamera{500, 510, 320, 240, 40};

SE3 random_pose(Random& random, double angle, double distance) {
  Vector6d xi;
  for (int k = 0; k < 3; ++k) {
    xi(k) = random.uniform(-distance, distance);
    xi(k + 3) = random.uniform(-angle, angle);
  }
  return SE3::exp(xi);
}

// Angle-axis and translation, for Ceres.
struct CeresPose {
  double v[6];
  explicit CeresPose(const SE3& T) {
    ceres::RotationMatrixToAngleAxis(T.R().data(), v);
    for (int k = 0; k < 3; ++k) v[3 + k] = T.t()(k);
  }
};

struct Reprojection {
  double u, v, u_right, weight;  // weight: 1 / sigma
  template <class T>
  bool operator()(const T* pose, const T* point, T* r) const {
    T p[3];
    ceres::AngleAxisRotatePoint(pose, point, p);
    for (int k = 0; k < 3; ++k) p[k] += pose[3 + k];
    const T x = kCamera.fx * p[0] / p[2] + kCamera.cx;
    r[0] = (u - x) * weight;
    r[1] = (v - (kCamera.fy * p[1] / p[2] + kCamera.cy)) * weight;
    r[2] = u_right >= 0 ? (u_right - (x - kCamera.bf / p[2])) * weight : T(0);
    return true;
  }
};

ceres::CostFunction* make_cost(double u, double v, double u_right, double inv_sigma2) {
  return new ceres::AutoDiffCostFunction<Reprojection, 3, 6, 3>(new Reprojection{u, v, u_right, std::sqrt(inv_sigma2)});
}

struct World {
  BundleProblem problem;
  std::vector<SE3> true_poses;
};

enum class Rows { mono, stereo, mixed };

// Cameras on an arc before a cloud of points, noise of a pixel, start values off the truth.
World make_world(uint64_t seed, int poses, int points, Rows rows, double outliers, bool loop = false) {
  Random random(seed);
  World world;
  BundleProblem& problem = world.problem;
  problem.camera = kCamera;
  for (int c = 0; c < poses; ++c) {
    const double s = static_cast<double>(c) / poses;
    const SE3 base = loop ? SE3(so3_exp({0, 6.283 * s, 0}), Eigen::Vector3d(0, 0, 4))
                          : SE3(so3_exp({0, 0.5 * (s - 0.5), 0}), Eigen::Vector3d(1.5 - 3 * s, 0.1 * s, 0));
    world.true_poses.push_back(random_pose(random, 0.02, 0.05) * base);
    problem.fixed.push_back(c < 2);
    problem.poses.push_back(c < 2 ? world.true_poses.back()
                                  : random_pose(random, 0.01, 0.03) * world.true_poses.back());
  }
  for (int p = 0; p < points; ++p) {
    Eigen::Vector3d at;
    if (loop) {
      const double angle = random.uniform(0, 6.283), r = random.uniform(8, 12);
      at = {r * std::sin(angle), random.uniform(-2, 2), r * std::cos(angle)};
    } else {
      at = {random.uniform(-4, 4), random.uniform(-3, 3), random.uniform(5, 12)};
    }
    std::vector<BundleObservation> seen;
    for (int c = 0; c < poses; ++c) {
      const Eigen::Vector3d p_c = world.true_poses[static_cast<size_t>(c)] * at;
      if (p_c.z() < 1) continue;
      const Eigen::Vector2d pixel = kCamera.project(p_c);
      if (pixel.x() < 0 || pixel.x() > 640 || pixel.y() < 0 || pixel.y() > 480) continue;
      BundleObservation o;
      o.pose = c;
      o.point = static_cast<int32_t>(problem.points.size());
      const bool wrong = random.uniform() < outliers;
      o.u = static_cast<float>(pixel.x() + random.normal() + (wrong ? 30 : 0));
      o.v = static_cast<float>(pixel.y() + random.normal());
      const bool stereo = rows == Rows::stereo || (rows == Rows::mixed && p % 2);
      const double u_right = pixel.x() - kCamera.bf / p_c.z() + random.normal();
      o.u_right = stereo && u_right > 0 ? static_cast<float>(u_right) : -1;
      o.inv_sigma2 = static_cast<float>(1 / std::pow(1.44, random.below(4)));
      seen.push_back(o);
    }
    if (seen.size() < 3) continue;
    problem.observations.insert(problem.observations.end(), seen.begin(), seen.end());
    problem.points.push_back(
        at + Eigen::Vector3d(random.uniform(-0.1, 0.1), random.uniform(-0.1, 0.1), random.uniform(-0.1, 0.1)));
  }
  return world;
}

// The cost Ceres ends with, twice its own (which halves).
double ceres_cost(const BundleProblem& problem, bool robust) {
  std::vector<CeresPose> poses(problem.poses.begin(), problem.poses.end());
  std::vector<Eigen::Vector3d> points = problem.points;
  ceres::Problem theirs;
  for (const BundleObservation& o : problem.observations) {
    if (!o.active) continue;
    const double bound = std::sqrt(o.u_right >= 0 ? kChi2Stereo : kChi2Mono);
    theirs.AddResidualBlock(make_cost(o.u, o.v, o.u_right, o.inv_sigma2),
                            robust ? new ceres::HuberLoss(bound) : nullptr, poses[static_cast<size_t>(o.pose)].v,
                            points[static_cast<size_t>(o.point)].data());
  }
  for (size_t c = 0; c < poses.size(); ++c) {
    if (problem.fixed[c] && theirs.HasParameterBlock(poses[c].v)) theirs.SetParameterBlockConstant(poses[c].v);
  }
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::SPARSE_SCHUR;
  options.max_num_iterations = 200;
  options.function_tolerance = 1e-14;
  options.gradient_tolerance = 1e-14;
  options.parameter_tolerance = 1e-14;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &theirs, &summary);
  return 2 * summary.final_cost;
}

TEST(Reprojection, JacobiansAgreeWithDifferences) {
  Random random(1);
  for (int trial = 0; trial < 100; ++trial) {
    const Eigen::Vector3d p(random.uniform(-2, 2), random.uniform(-2, 2), random.uniform(1, 8));
    for (const float u_right : {-1.0f, 200.0f}) {
      const Eigen::Matrix3d J_pi = projection_jacobian(p, kCamera, u_right >= 0);
      const Matrix3x6d J = pose_jacobian(J_pi, p);
      constexpr double kStep = 1e-6;
      for (int k = 0; k < 6; ++k) {
        Vector6d xi = Vector6d::Zero();
        xi(k) = kStep;
        const Eigen::Vector3d difference = (reprojection_residual(SE3::exp(-xi) * p, kCamera, 300, 200, u_right) -
                                            reprojection_residual(SE3::exp(xi) * p, kCamera, 300, 200, u_right)) /
                                           (2 * kStep);
        EXPECT_LT((difference - J.col(k)).norm(), 1e-5 * (1 + J.col(k).norm()));
      }
    }
  }
}

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
    const double u_right = pixel.x() - kCamera.bf / p_c.z() + 0.7 * random.normal();
    c.observations.add(c.truth.inverse() * p_c, static_cast<float>(u), static_cast<float>(v),
                       stereo ? static_cast<float>(std::max(0.0, u_right)) : -1.0f, 1);
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
        theirs.AddResidualBlock(make_cost(c.observations.u[i], c.observations.v[i], c.observations.u_right[i], 1),
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
  c.observations.add({0, 0, 5}, nan, 0, -1, 1);
  c.observations.add({nan, 0, 5}, 0, 0, -1, 1);
  c.observations.add(c.truth.inverse() * Eigen::Vector3d(0, 0, -3), 320, 240, -1, 1);  // behind
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

TEST(PoseOptimization, AllocatesNothing) {
  const PoseCase c = make_pose_case(4, 300, 0.2, Rows::mixed);
  std::vector<uint8_t> inlier(300);
  const long before = all_allocations;
  const PoseResult result = optimize_pose(c.start, c.observations, kCamera, {}, inlier);
  EXPECT_EQ(all_allocations, before);
  EXPECT_TRUE(result.ok);
}

TEST(BundleAdjustment, EndsWhereCeresEnds) {
  BundleAdjuster adjuster;
  for (const Rows rows : {Rows::mono, Rows::stereo, Rows::mixed}) {
    for (const bool robust : {true, false}) {
      World world = make_world(7, 10, 200, rows, robust ? 0.1 : 0);
      const double theirs = ceres_cost(world.problem, robust);
      const BundleSummary summary =
          adjuster.solve(world.problem, {.iterations = 100, .robust = robust, .relative_cost_change = 1e-12});
      EXPECT_TRUE(summary.ok);
      EXPECT_NEAR(summary.final_cost, theirs, 1e-6 * theirs) << static_cast<int>(rows) << robust;
      EXPECT_LT(summary.final_cost, summary.initial_cost);
    }
  }
}

// More poses than the dense solver takes.
World make_sparse_world(uint64_t seed) {
  World world = make_world(seed, 70, 150, Rows::mixed, 0, true);
  for (int k = 0; k < 20; ++k) {  // seen twice by one camera
    BundleObservation twice = world.problem.observations[static_cast<size_t>(k) * 7];
    twice.u += 0.5f;
    world.problem.observations.push_back(twice);
  }
  return world;
}

TEST(BundleAdjustment, SparseLoopEndsWhereCeresEnds) {
  World world = make_sparse_world(8);
  const double theirs = ceres_cost(world.problem, true);
  const BundleSummary summary =
      BundleAdjuster().solve(world.problem, {.iterations = 100, .relative_cost_change = 1e-12});
  EXPECT_NEAR(summary.final_cost, theirs, 1e-6 * theirs);
  for (const size_t c : {0, 1}) EXPECT_EQ(world.problem.poses[c].t(), world.true_poses[c].t());
}

TEST(BundleAdjustment, SparseAndDenseProblemsTakeTurnsWithTheSameBits) {
  BundleAdjuster adjuster;
  World dense_first = make_world(13, 10, 100, Rows::mixed, 0.05), sparse_first = make_sparse_world(14);
  World dense_again = dense_first, sparse_again = sparse_first;
  for (World* world : {&sparse_first, &dense_first, &sparse_again, &dense_again}) {
    // A point that comes behind cameras that should see it.
    world->problem.points[5] = -3 * world->problem.points[5];
    EXPECT_TRUE(adjuster.solve(world->problem, {.iterations = 5}).ok);
  }
  EXPECT_EQ(sparse_first.problem.points, sparse_again.problem.points);
  EXPECT_EQ(dense_first.problem.points, dense_again.problem.points);
  for (size_t c = 0; c < sparse_first.problem.poses.size(); ++c) {
    EXPECT_EQ(sparse_first.problem.poses[c].t(), sparse_again.problem.poses[c].t());
    EXPECT_EQ(sparse_first.problem.poses[c].R(), sparse_again.problem.poses[c].R());
  }
}

TEST(BundleAdjustment, ClassifiesOutliers) {
  World world = make_world(9, 8, 200, Rows::stereo, 0.1);
  BundleAdjuster().solve(world.problem, {.iterations = 30});
  const int inactive = classify_observations(world.problem);
  const auto all = static_cast<double>(world.problem.observations.size());
  EXPECT_GT(inactive, 0.08 * all);
  EXPECT_LT(inactive, 0.25 * all);
}

TEST(BundleAdjustment, InterruptionLeavesAValidState) {
  World world = make_world(10, 10, 300, Rows::mixed, 0);
  const World before = world;
  const std::atomic<bool> stop{true};
  const BundleSummary summary = BundleAdjuster().solve(world.problem, {.iterations = 50, .interrupt = &stop});
  EXPECT_TRUE(summary.interrupted);
  EXPECT_LE(summary.final_cost, summary.initial_cost);
  for (const SE3& pose : world.problem.poses) EXPECT_TRUE(pose.all_finite());
}

TEST(BundleAdjustment, DegenerateProblemsEndWell) {
  BundleAdjuster adjuster;
  BundleProblem empty;
  empty.camera = kCamera;
  EXPECT_FALSE(adjuster.solve(empty, {}).ok);
  World world = make_world(11, 6, 60, Rows::mono, 0);
  for (auto& fixed : world.problem.fixed) fixed = 0;  // no pose fixes the gauge
  world.problem.poses.push_back(SE3());               // a pose nobody observes from
  world.problem.fixed.push_back(0);
  world.problem.points.emplace_back(0, 0, 6);  // a point seen once
  BundleObservation once;
  once.point = static_cast<int32_t>(world.problem.points.size()) - 1;
  once.u = 320;
  once.v = 240;
  world.problem.observations.push_back(once);
  const BundleSummary summary = adjuster.solve(world.problem, {.iterations = 30});
  EXPECT_LT(summary.final_cost, summary.initial_cost);
  for (const SE3& pose : world.problem.poses) EXPECT_TRUE(pose.all_finite());
  for (const auto& point : world.problem.points) EXPECT_TRUE(point.allFinite());
}

TEST(BundleAdjustment, TwoRunsGiveTheSameBits) {
  World a = make_world(12, 12, 300, Rows::mixed, 0.05), b = a;
  BundleAdjuster adjuster;
  adjuster.solve(a.problem, {.iterations = 8});
  adjuster.solve(b.problem, {.iterations = 8});
  for (size_t c = 0; c < a.problem.poses.size(); ++c) {
    EXPECT_EQ(a.problem.poses[c].t(), b.problem.poses[c].t());
    EXPECT_EQ(a.problem.poses[c].R(), b.problem.poses[c].R());
  }
  EXPECT_EQ(a.problem.points, b.problem.points);
}

}  // namespace
}  // namespace covis
