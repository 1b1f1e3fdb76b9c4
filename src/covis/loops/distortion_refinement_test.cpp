// SPDX-License-Identifier: Apache-2.0
#include "covis/loops/distortion_refinement.h"

#include <gtest/gtest.h>

#include <utility>
#include <vector>

#include "covis/core/quantile.h"
#include "covis/optimization/free_scale.h"
#include "covis/optimization/test_lens_problem.h"

namespace covis {
namespace {

using lens_test::camera_with;
using lens_test::kFocal;
using lens_test::Motion;
using lens_test::seen_through;

constexpr int kManyViews = 36;

// The problem of a map that was made without distortion, through a lens of this focal length; the map claims 500.
BundleProblem problem_of(const Lens& lens, uint64_t seed, int views = kManyViews) {
  BundleProblem problem = seen_through(camera_with(lens), 1, Motion::sideways, seed, views);
  problem.camera.fx = problem.camera.fy = kFocal;
  return problem;
}

// As many more as there are.
void add_points_of_two_views(BundleProblem& problem) {
  const size_t points = problem.points.size();
  std::vector<int> taken(points, 0);
  for (const BundleObservation& o : std::vector<BundleObservation>(problem.observations)) {
    const auto point = static_cast<size_t>(o.point);
    if (++taken[point] > 2) continue;
    problem.observations.push_back(o);
    problem.observations.back().point += static_cast<int32_t>(points);
  }
  for (size_t p = 0; p < points; ++p) problem.points.push_back(problem.points[p]);
}

bool refine(BundleProblem& problem) {
  BundleAdjuster adjuster;
  return refine_distortion(problem, adjuster, kFocal);
}

TEST(DistortionRefinement, FindsWhatWasLeft) {
  BundleProblem problem = problem_of({.focal = kFocal, .k1 = 0.03, .k2 = -0.01}, 1);
  const BundleProblem before = problem;
  ASSERT_TRUE(refine(problem));
  EXPECT_EQ(problem.camera.fx, kFocal) << "the focal length that was given";
  EXPECT_NEAR(problem.camera.residual.k1, 0.03, 0.005);
  EXPECT_NEAR(problem.camera.residual.k2, -0.01, 0.005);
  double squares = 0;
  for (size_t k = 0; k < problem.observations.size(); ++k) {
    const BundleObservation &o = problem.observations[k], &was = before.observations[k];
    const Eigen::Vector2d straight = problem.camera.straightened({was.u, was.v}).value();
    EXPECT_NEAR(o.u, straight.x(), 1e-3);
    EXPECT_NEAR(o.v, straight.y(), 1e-3);
    const auto& pose = problem.poses[static_cast<size_t>(o.pose)];
    const Eigen::Vector2d at = problem.camera.project(pose * problem.points[static_cast<size_t>(o.point)]);
    squares += (at - Eigen::Vector2d(o.u, o.v)).squaredNorm();
  }
  EXPECT_LT(std::sqrt(squares / static_cast<double>(problem.observations.size())), 2 * lens_test::kPixelNoise);
}

// Asked again, it goes on from what it found: what has not changed moves nothing.
TEST(DistortionRefinementLong, GoesOnFromWhatItFound) {
  BundleProblem problem = problem_of({.focal = kFocal, .k1 = 0.03, .k2 = -0.01}, 2);
  ASSERT_TRUE(refine(problem));
  const Pinhole first = problem.camera;
  EXPECT_FALSE(refine(problem));
  Pinhole worse = first;
  worse.residual = {0.05, -0.02};
  for (BundleObservation& o : problem.observations) {
    const Eigen::Vector2d at = worse.straightened(first.bent({o.u, o.v})).value();
    o.u = static_cast<float>(at.x());
    o.v = static_cast<float>(at.y());
  }
  problem.camera = worse;
  ASSERT_TRUE(refine(problem));
  EXPECT_NEAR(problem.camera.residual.k1, first.residual.k1, 0.002);
  EXPECT_NEAR(problem.camera.residual.k2, first.residual.k2, 0.002);
}

// A phone whose focal length was looked up, and nothing else.
TEST(DistortionRefinementLong, FindsAnotherFocalLengthWithIt) {
  for (const double wrong : {0.97, 1.03}) {
    BundleProblem problem = problem_of({.focal = wrong * kFocal, .k1 = -0.1, .k2 = 0.03}, 8);
    add_points_of_two_views(problem);
    const std::vector<double> before = distances_from(0, problem);
    ASSERT_TRUE(refine(problem)) << wrong;
    std::vector<double> grown = distances_from(0, problem);
    for (size_t p = 0; p < grown.size(); ++p) grown[p] /= before[p];
    EXPECT_NEAR(quantile(std::move(grown), 0.5), 1, 0.003) << "the map keeps its unit";
    EXPECT_NEAR(problem.camera.fx, wrong * kFocal, 0.005 * kFocal);
    EXPECT_NEAR(problem.camera.residual.k1, -0.1, 0.01);
  }
}

// Points that two views see fit any lens.
TEST(DistortionRefinement, PointsThatFewSeeDoNotMatter) {
  BundleProblem problem = problem_of({.focal = kFocal, .k1 = 0.03, .k2 = -0.01}, 9);
  Random random(1);
  for (int k = 0; k < 12000; ++k) {
    const int32_t pose = k % 30, point = static_cast<int32_t>(problem.points.size());
    const double u = random.uniform(200, 440), v = random.uniform(150, 330);
    const auto T_wc = problem.poses[static_cast<size_t>(pose)].inverse();
    problem.points.push_back(T_wc * (random.uniform(4, 10) * problem.camera.unproject(u, v)));
    for (const int32_t view : {pose, pose + 1}) {
      const Eigen::Vector3d p_c = problem.poses[static_cast<size_t>(view)] * problem.points.back();
      const Eigen::Vector2d at = problem.camera.project(p_c);
      problem.observations.push_back(
          {.pose = view, .point = point, .u = static_cast<float>(at.x()), .v = static_cast<float>(at.y())});
    }
  }
  ASSERT_TRUE(refine(problem));
  EXPECT_NEAR(problem.camera.residual.k1, 0.03, 0.005);
}

// A focal length that had made up for a part of it goes back to the one given.
TEST(DistortionRefinement, GivesBackTheFocalLengthThatMadeUpForIt) {
  BundleProblem problem = problem_of({.focal = kFocal, .k1 = 0.03, .k2 = -0.01}, 3);
  problem.camera.fx = problem.camera.fy = 0.985 * kFocal;
  ASSERT_TRUE(refine(problem));
  EXPECT_EQ(problem.camera.fx, kFocal);
  EXPECT_EQ(problem.camera.fy, kFocal);
}

TEST(DistortionRefinement, RowsOfAnotherSizeStaySo) {
  Camera lens = camera_with({.focal = kFocal, .k1 = 0.03, .k2 = -0.01});
  lens.pinhole.fy = 1.03 * kFocal;
  BundleProblem problem = seen_through(lens, 1, Motion::sideways, 4, kManyViews);
  ASSERT_TRUE(refine(problem));
  EXPECT_NEAR(problem.camera.fy, 1.03 * kFocal, 1e-9);
  EXPECT_NEAR(problem.camera.residual.k1, 0.03, 0.005);
}

TEST(DistortionRefinementLong, AnExactCameraKeepsNone) {
  for (uint64_t seed = 10; seed < 16; ++seed) {
    BundleProblem problem = problem_of({.focal = kFocal}, seed);
    EXPECT_FALSE(refine(problem)) << seed;
    EXPECT_FALSE(problem.camera.residual.any());
  }
}

// Distortion could make up for a wrong focal length as well: observations say which of both it is.
TEST(DistortionRefinement, AWrongFocalLengthIsNoDistortion) {
  for (const double wrong : {0.97, 1.03}) {
    BundleProblem problem = problem_of({.focal = wrong * kFocal}, 5);
    EXPECT_FALSE(refine(problem)) << wrong;
  }
}

TEST(DistortionRefinement, FewViewsSayTooLittle) {
  BundleProblem problem = problem_of({.focal = kFocal, .k1 = 0.03, .k2 = -0.01}, 6, 29);
  EXPECT_FALSE(refine(problem));
}

TEST(DistortionRefinement, InterruptedItLeavesTheProblem) {
  BundleProblem problem = problem_of({.focal = kFocal, .k1 = 0.03, .k2 = -0.01}, 7);
  const Eigen::Vector3d point = problem.points.front();
  BundleAdjuster adjuster;
  const std::atomic<bool> interrupt = true;
  EXPECT_FALSE(refine_distortion(problem, adjuster, kFocal, &interrupt));
  EXPECT_EQ(problem.points.front(), point);
  EXPECT_FALSE(problem.camera.residual.any());
}

}  // namespace
}  // namespace covis
