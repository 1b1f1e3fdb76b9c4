// SPDX-License-Identifier: Apache-2.0
#include "covis/optimization/sim3_optimization.h"

#include <ceres/ceres.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "covis/core/random.h"
#include "covis/optimization/test_sim3.h"

namespace covis {
namespace {

const Pinhole kCamera1{500, 510, 320, 240, 0}, kCamera2{450, 440, 310, 250, 0};

struct Case {
  Sim3 truth;  // S_12
  std::vector<Sim3Match> matches;
  std::vector<uint8_t> wrong;
};

// Points before both cameras; each map has them off by a little, each image by a pixel's noise.
Case make_case(uint64_t seed, int count, double outliers, bool fix_scale) {
  Random random(seed);
  Case c;
  c.truth = random_sim3(random, 0.6, 0.2, fix_scale ? 0 : 0.7);
  const auto noise = [&](double size) {
    return Eigen::Vector3d(size * random.normal(), size * random.normal(), size * random.normal());
  };
  for (int k = 0; k < count; ++k) {
    Sim3Match match;
    const Eigen::Vector3d p(random.uniform(-2, 2), random.uniform(-1.5, 1.5), random.uniform(3, 8));
    const Eigen::Vector3d q = c.truth.inverse() * p;
    match.p_1 = p + noise(0.003);
    match.p_2 = q + noise(0.003);
    match.z_1 = kCamera1.project(p) + noise(0.7).head<2>();
    match.z_2 = kCamera2.project(q) + noise(0.7).head<2>();
    match.inv_sigma2_1 = k % 3 == 0 ? 0.7 : 1;
    c.wrong.push_back(random.uniform() < outliers);
    if (c.wrong.back()) {  // matched to another point
      const Eigen::Vector3d other(random.uniform(-2, 2), random.uniform(-1.5, 1.5), random.uniform(3, 8));
      match.p_2 = c.truth.inverse() * other;
      match.z_2 = kCamera2.project(match.p_2);
    }
    c.matches.push_back(match);
  }
  return c;
}

template <int N>
struct MatchResidual {
  Sim3 S_12;
  Sim3Match match;
  bool operator()(const double* parameters, double* out) const {
    Vector7d xi = Vector7d::Zero();
    std::copy_n(parameters, N, xi.data());
    Eigen::Vector4d e;
    if (!sim3_residual(Sim3::exp(xi) * S_12, match, kCamera1, kCamera2, e)) return false;
    e.head<2>() *= std::sqrt(match.inv_sigma2_1);
    e.tail<2>() *= std::sqrt(match.inv_sigma2_2);
    std::copy_n(e.data(), 4, out);
    return true;
  }
};

template <int N>
double ceres_cost(const Sim3& start, const Case& c, const std::vector<uint8_t>& use) {
  double xi[N] = {};
  ceres::Problem theirs;
  for (size_t k = 0; k < c.matches.size(); ++k) {
    if (!use[k]) continue;
    theirs.AddResidualBlock(new ceres::NumericDiffCostFunction<MatchResidual<N>, ceres::CENTRAL, 4, N>(
                                new MatchResidual<N>{start, c.matches[k]}),
                            nullptr, xi);
  }
  ceres::Solver::Options options;
  options.function_tolerance = options.gradient_tolerance = options.parameter_tolerance = 1e-14;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &theirs, &summary);
  return 2 * summary.final_cost;
}

TEST(Sim3Optimization, JacobiansAgreeWithDifferences) {
  const Case c = make_case(1, 100, 0.3, false);
  for (const Sim3Match& match : c.matches) {
    Eigen::Vector4d e, plus, minus;
    Eigen::Matrix<double, 4, 7> J;
    ASSERT_TRUE(sim3_residual(c.truth, match, kCamera1, kCamera2, e, &J));
    constexpr double kStep = 1e-6;
    for (int k = 0; k < 7; ++k) {
      const Vector7d xi = kStep * Vector7d::Unit(k);
      ASSERT_TRUE(sim3_residual(Sim3::exp(xi) * c.truth, match, kCamera1, kCamera2, plus));
      ASSERT_TRUE(sim3_residual(Sim3::exp(-xi) * c.truth, match, kCamera1, kCamera2, minus));
      EXPECT_LT(((minus - plus) / (2 * kStep) - J.col(k)).norm(), 1e-5 * (1 + J.col(k).norm()));
    }
  }
}

TEST(Sim3Optimization, EndsWhereCeresEnds) {
  for (const bool fix_scale : {false, true}) {
    for (uint64_t seed = 1; seed <= 10; ++seed) {
      const Case c = make_case(seed, 120, 0.2, fix_scale);
      Random random(seed + 100);
      const Sim3 start = random_sim3(random, 0.1, 0.05, fix_scale ? 0 : 0.1) * c.truth;
      const Sim3Result result = refine_sim3(start, c.matches, kCamera1, kCamera2, fix_scale);
      ASSERT_TRUE(result.ok);
      // The minimum over the same matches. One that came in or went out in the last look would count otherwise.
      const double theirs = fix_scale ? ceres_cost<6>(start, c, result.inlier) : ceres_cost<7>(start, c, result.inlier);
      EXPECT_GE(result.cost, theirs * (1 - 1e-9));
      EXPECT_LE(result.cost, theirs * (1 + 1e-3));
      EXPECT_LT((result.S_12 * c.truth.inverse()).log().norm(), 0.02);
      if (fix_scale) {
        EXPECT_EQ(result.S_12.scale(), start.scale());
      }
      for (size_t k = 0; k < c.wrong.size(); ++k) EXPECT_FALSE(c.wrong[k] && result.inlier[k]);
      EXPECT_GE(result.inliers, 0.9 * static_cast<double>(std::count(c.wrong.begin(), c.wrong.end(), 0)));
    }
    // With a bound that drops nothing: the minimum exactly.
    const Case clean = make_case(50, 120, 0, fix_scale);
    const Sim3Result all = refine_sim3(clean.truth, clean.matches, kCamera1, kCamera2, fix_scale, 1000);
    ASSERT_EQ(all.inliers, 120);
    const double theirs =
        fix_scale ? ceres_cost<6>(clean.truth, clean, all.inlier) : ceres_cost<7>(clean.truth, clean, all.inlier);
    EXPECT_NEAR(all.cost, theirs, 1e-9 * theirs);
  }
}

TEST(Sim3Optimization, RansacFindsItAmongWrongMatches) {
  for (const bool fix_scale : {false, true}) {
    for (uint64_t seed = 1; seed <= 30; ++seed) {
      const Case c = make_case(seed, 100, 0.5, fix_scale);
      const auto found = ransac_sim3(c.matches, kCamera1, kCamera2, fix_scale, seed);
      ASSERT_TRUE(found) << seed;
      EXPECT_LT((found->S_12 * c.truth.inverse()).log().norm(), 0.05) << seed;
      std::vector<Sim3Match> agreeing;
      for (size_t k = 0; k < c.matches.size(); ++k) {
        if (found->inlier[k]) agreeing.push_back(c.matches[k]);
      }
      const Sim3Result refined = refine_sim3(found->S_12, agreeing, kCamera1, kCamera2, fix_scale);
      ASSERT_TRUE(refined.ok);
      EXPECT_LT((refined.S_12 * c.truth.inverse()).log().norm(), 0.02) << seed;
      const auto again = ransac_sim3(c.matches, kCamera1, kCamera2, fix_scale, seed);
      EXPECT_EQ(again->S_12.t(), found->S_12.t());
      EXPECT_EQ(again->inlier, found->inlier);
    }
  }
}

TEST(Sim3Optimization, NothingIsFoundWhereNothingIs) {
  for (uint64_t seed = 1; seed <= 20; ++seed) {
    EXPECT_FALSE(ransac_sim3(make_case(seed, 100, 1, false).matches, kCamera1, kCamera2, false, seed));
  }
  const Case few = make_case(1, 15, 0, false);
  EXPECT_FALSE(ransac_sim3(few.matches, kCamera1, kCamera2, false, 1));
  EXPECT_TRUE(ransac_sim3(few.matches, kCamera1, kCamera2, false, 1, 10));
  EXPECT_FALSE(ransac_sim3({}, kCamera1, kCamera2, false, 1, 0));
  EXPECT_FALSE(refine_sim3(Sim3(), {}, kCamera1, kCamera2, false).ok);
  std::vector<Sim3Match> same(30, few.matches[0]);
  EXPECT_FALSE(ransac_sim3(same, kCamera1, kCamera2, false, 1));
}

TEST(Sim3Optimization, BadMatchesDoNotPoisonIt) {
  Case c = make_case(3, 60, 0, false);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  c.matches[3].z_1.x() = nan;
  c.matches[4].p_2.y() = nan;
  c.matches[5].p_1.z() = -2;  // behind
  const auto found = ransac_sim3(c.matches, kCamera1, kCamera2, false, 3);
  ASSERT_TRUE(found);
  const Sim3Result refined = refine_sim3(found->S_12, c.matches, kCamera1, kCamera2, false);
  EXPECT_TRUE(refined.ok);
  EXPECT_LT((refined.S_12 * c.truth.inverse()).log().norm(), 0.02);
  for (const size_t k : {3, 4, 5}) EXPECT_FALSE(refined.inlier[k] || found->inlier[k]);
}

// Points of two maps, each measured in views of the other: a plane before the first view, and views beside it.
std::vector<CarriedPoint> carried_points(uint64_t seed, const Sim3& S, int views) {
  Random random(seed);
  const Sim3 S_inverse = S.inverse();
  std::vector<CarriedPoint> points;
  for (int v = 0; v < views; ++v) {
    const SE3 T(so3_exp({0.1 * v, -0.15 * v, 0}), Eigen::Vector3d(0.6 * v, 0.3 * v, 0));
    for (int k = 0; k < 60; ++k) {
      const Eigen::Vector3d p_b(random.uniform(-0.5, 0.5), random.uniform(-0.5, 0.5), 4 + random.uniform(-0.02, 0.02));
      const bool back = k % 2 == 1;
      // In map a the views stand where S^-1 puts them, and see the same.
      const SE3 T_a = back ? (Sim3(T) * S).as_pose() : T;
      const Eigen::Vector3d seen = back ? T_a * (S_inverse * p_b) : T * p_b;
      const Eigen::Vector2d noise(0.7 * random.normal(), 0.7 * random.normal());
      points.push_back({back ? CarriedPoint::Way::back : CarriedPoint::Way::forth, back ? p_b : S_inverse * p_b, T_a,
                        kCamera1.project(seen) + noise});
    }
  }
  return points;
}

double angle_between(const Sim3& a, const Sim3& b) { return so3_log(a.R() * b.R().transpose()).norm(); }

TEST(Sim3Optimization, ViewsFromElsewhereTellWhatOneViewLeavesOpen) {
  double one = 0, many = 0;
  for (uint64_t seed = 1; seed <= 10; ++seed) {
    Random random(seed);
    const Sim3 truth = random_sim3(random, 0.5, 0.2, 0.3), start = Sim3::exp(0.02 * Vector7d::Ones()) * truth;
    for (const int views : {1, 6}) {
      const CarriedResult found = refine_sim3(start, carried_points(seed, truth, views), kCamera1, Scale::free);
      ASSERT_TRUE(found.ok);
      EXPECT_GT(found.agreeing, 55 * views);
      (views == 1 ? one : many) += angle_between(found.S, truth);
      if (views > 1) {
        EXPECT_NEAR(found.S.scale() / truth.scale(), 1, 0.01);
      }
    }
  }
  EXPECT_LT(5 * many, one);
}

// It says how the cost rises in any direction; a scale that is given stays.
TEST(Sim3Optimization, TheInformationOfCarriedPointsIsThatOfTheirPixels) {
  for (const Scale scale : {Scale::free, Scale::fixed}) {
    Random random(5);
    const Sim3 truth = random_sim3(random, 0.5, 0.2, scale == Scale::free ? 0.3 : 0);
    std::vector<CarriedPoint> points = carried_points(5, truth, 4);
    for (size_t k = 0; k < points.size(); k += 3) points[k].inv_sigma2 = 0.3;
    const auto cost = [&](const Sim3& S) {
      double sum = 0;
      for (const CarriedPoint& point : points) {
        const bool back = point.way == CarriedPoint::Way::back;
        const Eigen::Vector3d seen = point.T * ((back ? S.inverse() : S) * point.p);
        sum += (point.z - kCamera1.project(seen)).squaredNorm() * point.inv_sigma2;
      }
      return sum;
    };
    const CarriedResult found = refine_sim3(truth, points, kCamera1, scale);
    ASSERT_TRUE(found.ok);
    const double least = cost(found.S);
    for (int k = 0; k < 20; ++k) {
      Vector7d step;
      for (double& value : step) value = random.uniform(-1, 1);
      if (scale == Scale::fixed) step(6) = 0;
      step *= 0.001 / step.norm();
      const double rise = (cost(Sim3::exp(step) * found.S) + cost(Sim3::exp(-step) * found.S)) / 2 - least;
      EXPECT_NEAR(rise / step.dot(found.information * step), 1, 0.05) << k;
    }
    if (scale == Scale::free) continue;
    EXPECT_EQ(found.S.scale(), 1);
    EXPECT_EQ(found.information(6, 6), 1);
    EXPECT_EQ(found.information.row(6).head<6>().norm(), 0);
  }
}

TEST(Sim3Optimization, CarriedPointsThatAreWrongAreLeftOut) {
  Random random(3);
  const Sim3 truth = random_sim3(random, 0.5, 0.2, 0);
  const Sim3 start = Sim3::exp(0.01 * Vector7d::Ones()) * truth;
  std::vector<CarriedPoint> points = carried_points(3, truth, 5);
  for (size_t k = 0; k < points.size(); k += 10) points[k].z.x() += 40;
  const CarriedResult found = refine_sim3(start, points, kCamera1, Scale::free);
  ASSERT_TRUE(found.ok);
  EXPECT_NEAR(found.agreeing, 270, 10);
  EXPECT_NEAR(found.S.scale(), 1, 0.01);
  EXPECT_LT(angle_between(found.S, truth), 0.01);
}

TEST(Sim3Optimization, CarriedPointsBehindTheCameraTellNothing) {
  std::vector<CarriedPoint> points = carried_points(4, Sim3(), 2);
  for (CarriedPoint& point : points) point.p.z() = -4;
  const CarriedResult found = refine_sim3(Sim3(), points, kCamera1, Scale::free);
  EXPECT_FALSE(found.ok);
  EXPECT_EQ(found.S.scale(), 1);
}

}  // namespace
}  // namespace covis
