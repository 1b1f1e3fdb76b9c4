// SPDX-License-Identifier: Apache-2.0
#include "covis/optimization/pose_graph.h"

#include <ceres/ceres.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "covis/core/random.h"
#include "covis/optimization/test_sim3.h"

namespace covis {
namespace {

// Cameras on a circle, looking outwards.
std::vector<Sim3> circle(int count) {
  std::vector<Sim3> poses;
  for (int c = 0; c < count; ++c) {
    poses.emplace_back(so3_exp({0, 6.283185307179586 * c / count, 0}), Eigen::Vector3d(0, 0, -4), 1.0);
  }
  return poses;
}

PoseGraphProblem random_problem(uint64_t seed, int count, bool fix_scale) {
  Random random(seed);
  PoseGraphProblem problem;
  problem.fix_scale = fix_scale;
  problem.poses = circle(count);
  problem.fixed.assign(static_cast<size_t>(count), 0);
  problem.fixed[0] = 1;
  const double drift = fix_scale ? 0 : 0.05;
  for (int32_t i = 0; i < count; ++i) {
    for (const int32_t gap : {1, 2, 3, 5, 11}) {
      const int32_t j = (i + gap) % count;
      const Sim3 S_ji = problem.poses[static_cast<size_t>(j)] * problem.poses[static_cast<size_t>(i)].inverse();
      problem.edges.push_back({i, j, random_sim3(random, 0.05, 0.03, drift) * S_ji, random.uniform(0.1, 1)});
    }
  }
  for (int c = 1; c < count; ++c) {
    Sim3& S = problem.poses[static_cast<size_t>(c)];
    S = random_sim3(random, 0.2, 0.1, 2 * drift) * S;
  }
  return problem;
}

// The same edge for Ceres, each pose as exp(xi) * its start.
template <int N>
struct EdgeResidual {
  Sim3 S_ji, S_iw, S_jw;
  double weight;
  bool operator()(const double* xi_i, const double* xi_j, double* e) const {
    Vector7d i = Vector7d::Zero(), j = Vector7d::Zero();
    std::copy_n(xi_i, N, i.data());
    std::copy_n(xi_j, N, j.data());
    const Vector7d r = std::sqrt(weight) * pose_graph_residual(S_ji, Sim3::exp(i) * S_iw, Sim3::exp(j) * S_jw);
    std::copy_n(r.data(), N, e);
    return true;
  }
};

template <int N>
double ceres_cost(const PoseGraphProblem& problem) {
  std::vector<Vector7d> xi(problem.poses.size(), Vector7d::Zero());
  ceres::Problem theirs;
  for (const PoseGraphEdge& edge : problem.edges) {
    const auto i = static_cast<size_t>(edge.i), j = static_cast<size_t>(edge.j);
    auto* cost = new ceres::NumericDiffCostFunction<EdgeResidual<N>, ceres::CENTRAL, N, N, N>(
        new EdgeResidual<N>{edge.S_ji, problem.poses[i], problem.poses[j], edge.weight});
    theirs.AddResidualBlock(cost, nullptr, xi[i].data(), xi[j].data());
  }
  for (size_t c = 0; c < xi.size(); ++c) {
    if (problem.fixed[c]) theirs.SetParameterBlockConstant(xi[c].data());
  }
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  options.max_num_iterations = 100;
  options.function_tolerance = options.gradient_tolerance = options.parameter_tolerance = 1e-12;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &theirs, &summary);
  return 2 * summary.final_cost;
}

TEST(PoseGraph, JacobiansAgreeWithDifferences) {
  Random random(1);
  for (int trial = 0; trial < 200; ++trial) {
    const Sim3 S_ji = random_sim3(random, 2, 1, 0.5), S_iw = random_sim3(random, 3, 1, 0.5);
    // The residual from next to nothing to far away.
    const double size = std::pow(10.0, random.uniform(-9, 0));
    const Sim3 S_jw = random_sim3(random, size, size, size) * S_ji * S_iw;
    Matrix7d J_i, J_j;
    const Vector7d e = pose_graph_residual(S_ji, S_iw, S_jw, J_i, J_j);
    EXPECT_LT((e - pose_graph_residual(S_ji, S_iw, S_jw)).norm(), 1e-12);
    constexpr double kStep = 1e-5;
    for (int k = 0; k < 7; ++k) {
      const Vector7d xi = kStep * Vector7d::Unit(k);
      const Sim3 plus = Sim3::exp(xi), minus = Sim3::exp(-xi);
      const Vector7d by_i =
          pose_graph_residual(S_ji, plus * S_iw, S_jw) - pose_graph_residual(S_ji, minus * S_iw, S_jw);
      const Vector7d by_j =
          pose_graph_residual(S_ji, S_iw, plus * S_jw) - pose_graph_residual(S_ji, S_iw, minus * S_jw);
      EXPECT_LT((by_i / (2 * kStep) - J_i.col(k)).norm(), 1e-7 * (1 + J_i.norm()));
      EXPECT_LT((by_j / (2 * kStep) - J_j.col(k)).norm(), 1e-7 * (1 + J_j.norm()));
    }
  }
}

TEST(PoseGraph, EndsWhereCeresEnds) {
  for (const bool fix_scale : {false, true}) {
    PoseGraphProblem problem = random_problem(2, 30, fix_scale);
    problem.fixed[7] = 1;
    const PoseGraphProblem before = problem;
    const double theirs = fix_scale ? ceres_cost<6>(problem) : ceres_cost<7>(problem);
    const PoseGraphSummary summary = optimize_pose_graph(problem, {.iterations = 100, .relative_cost_change = 1e-12});
    EXPECT_TRUE(summary.ok);
    EXPECT_NEAR(summary.final_cost, theirs, 1e-6 * theirs);
    EXPECT_LT(summary.final_cost, 0.5 * summary.initial_cost);
    for (const size_t c : {0, 7}) {
      EXPECT_EQ(problem.poses[c].R(), before.poses[c].R());
      EXPECT_EQ(problem.poses[c].t(), before.poses[c].t());
      EXPECT_EQ(problem.poses[c].scale(), before.poses[c].scale());
    }
    for (const Sim3& S : problem.poses) {
      if (fix_scale) {
        EXPECT_EQ(S.scale(), 1);
      }
    }
  }
}

// Camera centres in units of the world that each camera believes in, against the truth.
double rms_error(const std::vector<Sim3>& poses, const std::vector<Sim3>& truth) {
  double sum = 0;
  for (size_t c = 0; c < poses.size(); ++c)
    sum += (poses[c].as_pose().centre() - truth[c].as_pose().centre()).squaredNorm();
  return std::sqrt(sum / static_cast<double>(poses.size()));
}

TEST(PoseGraph, StraightensALoopWithScaleDrift) {
  const std::vector<Sim3> truth = circle(120);
  PoseGraphProblem problem;
  problem.fixed.assign(truth.size(), 0);
  problem.fixed[0] = 1;
  // Tracking's measurements shrink by 0.5 % with each camera, and rotate a little.
  Vector7d drift;
  drift << 0.001, 0, 0.001, 0, 0.001, 0, -0.005;
  problem.poses.push_back(truth[0]);
  for (size_t c = 1; c < truth.size(); ++c) {
    const Sim3 S = Sim3::exp(drift) * truth[c] * truth[c - 1].inverse();
    problem.poses.push_back(S * problem.poses.back());
    problem.edges.push_back({static_cast<int32_t>(c) - 1, static_cast<int32_t>(c), S});
  }
  problem.edges.push_back({static_cast<int32_t>(truth.size()) - 1, 0, truth.front() * truth.back().inverse()});
  const double before = rms_error(problem.poses, truth);
  const PoseGraphSummary summary = optimize_pose_graph(problem);
  EXPECT_TRUE(summary.ok);
  EXPECT_LT(summary.final_cost, 0.05 * summary.initial_cost);
  EXPECT_GT(before, 0.5);
  EXPECT_LT(rms_error(problem.poses, truth), 0.1 * before);
  for (const Sim3& S : problem.poses) EXPECT_NEAR(S.scale(), 1, 0.02);
}

TEST(PoseGraph, TwoRunsGiveTheSameBits) {
  PoseGraphProblem a = random_problem(4, 60, false), b = a;
  optimize_pose_graph(a);
  optimize_pose_graph(b);
  for (size_t c = 0; c < a.poses.size(); ++c) {
    EXPECT_EQ(a.poses[c].R(), b.poses[c].R());
    EXPECT_EQ(a.poses[c].t(), b.poses[c].t());
    EXPECT_EQ(a.poses[c].scale(), b.poses[c].scale());
  }
}

TEST(PoseGraph, DegenerateProblemsEndWell) {
  PoseGraphProblem empty;
  EXPECT_FALSE(optimize_pose_graph(empty).ok);
  PoseGraphProblem held = random_problem(5, 20, false);
  held.fixed.assign(held.poses.size(), 1);
  EXPECT_FALSE(optimize_pose_graph(held).ok);

  PoseGraphProblem loose = random_problem(5, 20, false);  // the gauge is free, and one camera has no edges
  loose.fixed[0] = 0;
  loose.poses.emplace_back();
  loose.fixed.push_back(0);
  const PoseGraphSummary summary = optimize_pose_graph(loose);
  EXPECT_TRUE(summary.ok);
  EXPECT_LT(summary.final_cost, summary.initial_cost);
  for (const Sim3& S : loose.poses) EXPECT_TRUE(S.all_finite());
  EXPECT_EQ(loose.poses.back().t(), Eigen::Vector3d::Zero());

  PoseGraphProblem bad = random_problem(6, 20, false);
  bad.edges[3].S_ji = Sim3(Eigen::Matrix3d::Identity(), {0, std::numeric_limits<double>::quiet_NaN(), 0}, 1);
  EXPECT_FALSE(optimize_pose_graph(bad).ok);
  for (const Sim3& S : bad.poses) EXPECT_TRUE(S.all_finite());
}

}  // namespace
}  // namespace covis
