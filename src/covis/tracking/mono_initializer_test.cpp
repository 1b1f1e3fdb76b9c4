// SPDX-License-Identifier: Apache-2.0
#include "covis/tracking/mono_initializer.h"

#include <gmock/gmock.h>

#include "covis/tracking/test_frame.h"

namespace covis {
namespace {

class MonoInitializerTest : public testing::Test {
 protected:
  // A wall whose points are seen at the fine levels that the initialiser matches.
  static PointScene wall(int count = 600, uint64_t seed = 1) {
    PointScene scene = PointScene::wall(count, 20, seed);
    for (PointScene::Point& p : scene.points) p.reach = 5;
    return scene;
  }
  // Points of a slanted plane, some five metres ahead.
  static PointScene plane() {
    PointScene scene = wall();
    for (PointScene::Point& p : scene.points) p.position_w.z() = 5 + 0.3 * p.position_w.x() - 0.2 * p.position_w.y();
    return scene;
  }
  static FeaturesPtr view(const PointScene& scene, const SE3& T_cw, uint64_t seed = 0) {
    return scene.view(T_cw, Sensor::monocular, seed).features;
  }
  // Offers views until there is a map: an initial one of the scene's truth.
  std::optional<InitialMapRequest> begin(const PointScene& scene, const std::vector<SE3>& poses) {
    std::optional<InitialMapRequest> made;
    for (size_t i = 0; i < poses.size() && !made; ++i) {
      const auto frame = static_cast<int64_t>(i);
      made = initializer.offer(scene.camera, view(scene, poses[i], i), frame, 100 * frame);
    }
    return made;
  }
  // The map is the scene's, but for its unit.
  static void expect_true(const InitialMapRequest& made, const PointScene& scene, const SE3& first, const SE3& second,
                          double bound) {
    const SE3 truth = second * first.inverse();
    const double unit = truth.t().norm();
    EXPECT_LT((made.T_21.t() - truth.t() / unit).norm(), bound);
    EXPECT_LT(so3_log(made.T_21.R() * truth.R().transpose()).norm(), bound);
    const PointScene::View seen = scene.view(first, Sensor::monocular);
    for (const InitialMapRequest::Point& p : made.points) {
      const Eigen::Vector2d pixel(made.first.features->x[p.feature_first], made.first.features->y[p.feature_first]);
      EXPECT_LT((scene.camera.project(p.position_w) - pixel).norm(), 3);
      if (scene.noise > 0) continue;
      const Eigen::Vector3d p_c = first * scene.points[seen.point[p.feature_first]].position_w;
      EXPECT_LT((unit * p.position_w - p_c).norm(), 0.02 * p_c.norm());
    }
  }

  StartOptions options;
  MonoInitializer initializer{options, 0};
};

TEST_F(MonoInitializerTest, TwoViewsWithParallaxMakeTheMapAsItIs) {
  const PointScene scene = wall();
  const auto made = begin(scene, {scene.T_cw(0), scene.T_cw(2)});
  ASSERT_TRUE(made) << describe(initializer.reason());
  EXPECT_EQ(made->first.frame, 0);
  EXPECT_EQ(made->second.frame, 1);
  EXPECT_EQ(made->second.stamp, 100);
  EXPECT_GT(made->points.size(), 100u);
  EXPECT_EQ(initializer.matches() >= static_cast<int>(made->points.size()), true);
  expect_true(*made, scene, scene.T_cw(0), scene.T_cw(2), 1e-3);
}

TEST_F(MonoInitializerTest, NoiseOfAPixelIsBorne) {
  PointScene scene = wall();
  scene.noise = 0.5;
  scene.flipped_bits = 10;
  const auto made = begin(scene, {scene.T_cw(0), scene.T_cw(3)});
  ASSERT_TRUE(made) << describe(initializer.reason());
  expect_true(*made, scene, scene.T_cw(0), scene.T_cw(3), 0.05);
}

TEST_F(MonoInitializerTest, APlaneServesToo) {
  const PointScene scene = plane();
  const SE3 second = SE3(so3_exp({0.02, 0.05, 0.03}), {-0.6, 0.1, 0.2});
  const auto made = begin(scene, {SE3(), second});
  ASSERT_TRUE(made) << describe(initializer.reason());
  expect_true(*made, scene, SE3(), second, 0.01);
}

TEST_F(MonoInitializerTest, WithoutParallaxItWaits) {
  const PointScene scene = wall();
  EXPECT_FALSE(begin(scene, {SE3()}));
  EXPECT_EQ(initializer.reason(), NoPoseReason::waiting_for_parallax);
  EXPECT_FALSE(initializer.offer(scene.camera, view(scene, SE3()), 1, 100));
  EXPECT_EQ(initializer.reason(), NoPoseReason::low_parallax);
  EXPECT_GT(initializer.matches(), options.init_min_matches);
  const SE3 turned(so3_exp({0, 0.05, 0}), Eigen::Vector3d::Zero());
  EXPECT_FALSE(initializer.offer(scene.camera, view(scene, turned), 2, 200)) << "a turn gives none";
  const auto made = initializer.offer(scene.camera, view(scene, scene.T_cw(2)), 3, 300);
  ASSERT_TRUE(made) << "and the first view still serves";
  EXPECT_EQ(made->first.frame, 0);
}

TEST_F(MonoInitializerTest, TooFewFeaturesAreNoFirstView) {
  const PointScene few = wall(100);
  EXPECT_FALSE(begin(few, {SE3()}));
  EXPECT_EQ(initializer.reason(), NoPoseReason::few_features);
  const PointScene scene = wall();
  EXPECT_FALSE(initializer.offer(scene.camera, view(scene, SE3()), 1, 100));
  EXPECT_EQ(initializer.reason(), NoPoseReason::waiting_for_parallax);
}

TEST_F(MonoInitializerTest, AViewThatMatchesTooLittleIsTheNewFirstView) {
  const PointScene scene = wall(600, 1), other = wall(600, 2);
  EXPECT_FALSE(begin(scene, {SE3()}));
  EXPECT_FALSE(initializer.offer(other.camera, view(other, SE3()), 1, 100));
  EXPECT_EQ(initializer.reason(), NoPoseReason::few_matches_with_first_view);
  EXPECT_LT(initializer.matches(), options.init_min_matches);
  const auto made = initializer.offer(other.camera, view(other, other.T_cw(2)), 2, 200);
  ASSERT_TRUE(made);
  EXPECT_EQ(made->first.frame, 1);
}

TEST_F(MonoInitializerTest, AResetForgetsTheFirstView) {
  const PointScene scene = wall();
  EXPECT_FALSE(begin(scene, {SE3()}));
  initializer.reset();
  EXPECT_EQ(initializer.reason(), NoPoseReason::waiting_for_first_view);
  EXPECT_FALSE(initializer.offer(scene.camera, view(scene, scene.T_cw(2)), 1, 100));
  EXPECT_EQ(initializer.reason(), NoPoseReason::waiting_for_parallax);
}

TEST_F(MonoInitializerTest, TheWindowFollowsTheKeypoints) {
  options.init_window = 30;
  MonoInitializer narrow(options, 0);
  const PointScene scene = wall();
  const auto sideways = [](double x) { return SE3(Eigen::Matrix3d::Identity(), Eigen::Vector3d(-x, 0, 0)); };
  narrow.offer(scene.camera, view(scene, SE3()), 0, 0);
  std::optional<InitialMapRequest> made;
  options.init_min_parallax = 20;
  MonoInitializer demanding(options, 0);
  demanding.offer(scene.camera, view(scene, SE3()), 0, 0);
  for (int i = 1; i <= 6; ++i) demanding.offer(scene.camera, view(scene, sideways(0.15 * i)), i, i);
  EXPECT_GT(demanding.matches(), 100) << "70 to 110 pixels away, by steps of 20";
  narrow.offer(scene.camera, view(scene, sideways(0.06)), 1, 1);
  EXPECT_GT(narrow.matches(), 100);
  narrow.offer(scene.camera, view(scene, sideways(0.9)), 2, 2);
  EXPECT_LT(narrow.matches(), 20) << "at once they are out of the window";
}

TEST_F(MonoInitializerTest, TheSameViewsMakeTheSameMap) {
  PointScene scene = wall();
  scene.noise = 0.5;
  const std::vector<SE3> poses{scene.T_cw(0), scene.T_cw(3)};
  const auto a = begin(scene, poses);
  initializer.reset();
  const auto b = begin(scene, poses);
  ASSERT_TRUE(a && b);
  EXPECT_EQ(a->T_21.t(), b->T_21.t());
  EXPECT_EQ(a->points.size(), b->points.size());
}

}  // namespace
}  // namespace covis
