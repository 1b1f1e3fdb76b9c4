// SPDX-License-Identifier: Apache-2.0
#include "covis/mapping/depth_against_motion.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>

#include "covis/core/random.h"
#include "covis/features/test_features.h"
#include "covis/geometry/se3.h"

namespace covis {
namespace {

const Pinhole kCamera = [] {
  Pinhole camera;
  camera.fx = camera.fy = 500;
  camera.cx = 320;
  camera.cy = 240;
  camera.bf = 40;
  return camera;
}();

using MeasuredDepth = std::function<double(double depth, Random& random)>;

// Points of a room as a camera sees them that has moved to the right, a little forward, and turned.
struct Views {
  std::shared_ptr<Features> a = std::make_shared<Features>(no_features()),
                            b = std::make_shared<Features>(no_features());

  Views(double way, const MeasuredDepth& measured) {
    Random random(5);
    const SE3 T_ba(so3_exp(Eigen::Vector3d(0.01, -0.04, 0.02)), Eigen::Vector3d(-way, 0.1 * way, -0.3 * way));
    for (int i = 0; i < 400; ++i) {
      const double z = random.uniform(1, 5);
      const Eigen::Vector3d in_a = z * kCamera.unproject(random.uniform(20, 620), random.uniform(20, 460));
      const Descriptor descriptor = random_descriptor(random);
      add_point(*a, in_a, descriptor, measured, random);
      add_point(*b, T_ba * in_a, descriptor, measured, random);
    }
    finish(*a);
    finish(*b);
  }
  std::optional<DepthAgainstMotion> compare() const { return compare_depth_with_motion(*a, *b, kCamera, 1); }

 private:
  static void add_point(Features& f, const Eigen::Vector3d& p, const Descriptor& descriptor,
                        const MeasuredDepth& measured, Random& random) {
    const Eigen::Vector2d at = kCamera.project(p);
    const double x = at.x() + 0.5 * random.normal(), y = at.y() + 0.5 * random.normal();
    add(f, {.x = x, .y = y, .descriptor = descriptor, .depth = measured(p.z(), random)}, kCamera.bf);
  }
};

double noisy(double depth, Random& random) { return depth + 0.003 * depth * depth * random.normal(); }

TEST(DepthAgainstMotion, RightDepthAgrees) {
  const auto found = Views(0.3, noisy).compare();
  ASSERT_TRUE(found);
  EXPECT_GT(found->points, 200);
  EXPECT_LT(found->error(), 0.2);
  EXPECT_GT(found->of_scene, 0.2);
  EXPECT_GT(found->explained, 0.7);
}

TEST(DepthAgainstMotion, AWrongScaleDoesNotShow) {
  const auto found = Views(0.3, [](double depth, Random& random) { return noisy(depth, random) / 5; }).compare();
  ASSERT_TRUE(found);
  EXPECT_LT(found->error(), 0.2);
}

TEST(DepthAgainstMotion, NonsenseDisagrees) {
  const MeasuredDepth kinds[] = {
      [](double, Random&) { return 2.0; }, [](double, Random& random) { return random.uniform(0.5, 6); },
      [](double depth, Random&) { return 4 / depth; }, [](double depth, Random&) { return 6 - depth; }};
  for (const MeasuredDepth& kind : kinds) {
    const auto found = Views(0.3, kind).compare();
    ASSERT_TRUE(found);
    EXPECT_GT(found->error(), 0.9) << &kind - kinds;
    EXPECT_LT(found->explained, 0.6) << &kind - kinds;
  }
}

// The shift of a right image that came late, in pixels, adds to the disparity.
TEST(DepthAgainstMotion, AConstantErrorOfDisparityDisagrees) {
  const auto found = Views(0.3, [](double depth, Random&) { return kCamera.bf / (kCamera.bf / depth + 40); }).compare();
  ASSERT_TRUE(found);
  EXPECT_GT(found->error(), 0.6);
}

// A narrow baseline in a wide scene: half a pixel is a tenth of a far point's disparity.
TEST(DepthAgainstMotion, NoiseOfFarDepthsIsNoContradiction) {
  Pinhole camera = kCamera;
  camera.bf = 24;
  const auto measured = [&](double depth, Random& random) {
    return camera.bf / std::max(0.01, camera.bf / depth + (depth > 3 ? 4 : 0.5) * random.normal());
  };
  const Views views(0.3, measured);
  const auto found = compare_depth_with_motion(*views.a, *views.b, camera, 1);
  ASSERT_TRUE(found);
  EXPECT_LT(found->error(), 0.4);
  camera.bf = 4;
  EXPECT_FALSE(compare_depth_with_motion(*views.a, *views.b, camera, 1)) << "no disparity is known to 5 %";
  camera.depth_noise = {0.01, 0.2};
  EXPECT_FALSE(compare_depth_with_motion(*views.a, *views.b, camera, 1)) << "no depth of a depth camera is";
}

TEST(DepthAgainstMotion, ACameraThatStandsTellsNothing) { EXPECT_FALSE(Views(0, noisy).compare()); }

// How many comparisons come of so many views, seen in turns from two places.
size_t answers_of(MotionDepthCheck& check, const Views& views, int count,
                  MotionDepthCheck::Pace pace = MotionDepthCheck::Pace::usual) {
  size_t answers = 0;
  for (int k = 0; k < count; ++k) answers += check.add(k % 2 ? views.a : views.b, kCamera, pace).size();
  return answers;
}

// A view is compared with the last one, and with the one before, which was taken at the same place here.
TEST(MotionDepthCheck, AsksEveryPairOnlyAtFirst) {
  const Views views(0.3, noisy);
  MotionDepthCheck check;
  EXPECT_TRUE(check.add(views.a, kCamera).empty()) << "the first view";
  EXPECT_EQ(answers_of(check, views, 10), 10u);
  EXPECT_EQ(answers_of(check, views, 10), 4u) << "two views of ten";
  EXPECT_EQ(answers_of(check, views, 10, MotionDepthCheck::Pace::every_view), 10u) << "while depth is doubted";
}

TEST(MotionDepthCheck, ComparesWithTheTwoViewsBefore) {
  const Views near(0.3, noisy), far(0.6, noisy);  // their first views are the same
  MotionDepthCheck check;
  EXPECT_EQ(check.add(near.a, kCamera).size(), 0u);
  EXPECT_EQ(check.add(near.b, kCamera).size(), 1u);
  EXPECT_EQ(check.add(far.b, kCamera).size(), 2u);
}

TEST(MotionDepthCheck, AsksSeldomOfACameraThatStands) {
  const Views still(0, noisy), views(0.3, noisy);
  MotionDepthCheck check;
  for (int k = 0; k < 21; ++k) EXPECT_TRUE(check.add(k % 2 ? still.a : still.b, kCamera).empty());
  EXPECT_EQ(answers_of(check, views, 20), 8u) << "one view in five";
}

}  // namespace
}  // namespace covis
