// SPDX-License-Identifier: Apache-2.0
#include "covis/matching/projection_match.h"

#include <gtest/gtest.h>

#include "covis/map/test_point_scene.h"

namespace covis {
namespace {

// A place of a map, and a view of it that is no key frame.
struct ProjectionMatchTest : testing::Test {
  void SetUp() override {
    world.add_key_frames(3);
    const auto map = world.shared.read();
    points.id = points_of(*map, world.frames);
    points.copy(*map);
    for (size_t p = 0; p < world.handles.size(); ++p) {
      const int32_t k = world.handles[p].valid() ? index_of(points, world.handles[p]) : -1;
      if (k >= 0) scene_point[static_cast<size_t>(k)] = p;
    }
  }
  int match(const SE3& from, const MatchGate& gate, std::span<const uint8_t> known = {},
            std::span<const uint8_t> taken = {}) {
    return matcher.match(points, {scene.camera, *view.features, from}, gate, known, taken);
  }

  const PointScene scene = PointScene::wall();
  SceneMap world{scene};
  const SE3 T_cw = scene.T_cw(3);
  const PointScene::View view = scene.view(T_cw);
  PointSet points;
  std::vector<size_t> scene_point = std::vector<size_t>(scene.points.size());
  ProjectionMatcher matcher;
};

TEST_F(ProjectionMatchTest, FindsThePointsInViewWhereTheyAre) {
  const int in_view = match(T_cw, MatchGate::loop(4));
  EXPECT_GT(in_view, 150);
  EXPECT_GT(static_cast<int>(matcher.matches().size()), in_view * 9 / 10);
  for (const PointMatch& m : matcher.matches()) EXPECT_EQ(view.point[m.feature], scene_point[m.point]);
  EXPECT_TRUE(std::is_sorted(matcher.matches().begin(), matcher.matches().end(),
                             [](const PointMatch& a, const PointMatch& b) { return a.point < b.point; }));
}

TEST_F(ProjectionMatchTest, AWindowHoldsThemOrNot) {
  const SE3 off = SE3::exp((Vector6d() << 0.05, 0, 0, 0, 0, 0).finished()) * T_cw;  // 3 to 6 pixels
  match(off, MatchGate::loop(10));
  EXPECT_GT(matcher.matches().size(), 150u);
  match(off, MatchGate::loop(1));
  EXPECT_LT(matcher.matches().size(), 100u);
}

TEST_F(ProjectionMatchTest, ThereIsNothingBehindTheCamera) {
  const SE3 back(so3_exp({0, std::numbers::pi, 0}), Eigen::Vector3d::Zero());
  EXPECT_EQ(match(back * T_cw, MatchGate::loop(10)), 0);
  EXPECT_TRUE(matcher.matches().empty());
}

TEST_F(ProjectionMatchTest, KnownPointsAndTakenFeaturesArePassedOver) {
  const int in_view = match(T_cw, MatchGate::loop(4));
  const PointMatch first = matcher.matches().front(), second = matcher.matches()[1];
  std::vector<uint8_t> known(points.size()), taken(view.point.size());
  known[first.point] = taken[second.feature] = 1;
  EXPECT_EQ(match(T_cw, MatchGate::loop(4), known, taken), in_view) << "known ones are in view";
  for (const PointMatch& m : matcher.matches()) {
    EXPECT_NE(m.point, first.point);
    EXPECT_NE(m.feature, second.feature);
  }
}

TEST_F(ProjectionMatchTest, AViewIsPredictedWithinTheRangeOfDistances) {
  ASSERT_GT(match(T_cw, MatchGate::loop(4)), 0);
  const size_t k = matcher.matches().front().point;
  const auto predicted = predict_view(points.viewable(k), T_cw, T_cw.centre(), scene.camera, *view.features);
  ASSERT_TRUE(predicted);
  EXPECT_NEAR(predicted->u, scene.camera.project(T_cw * points.position(k)).x(), 1e-3);
  points.d_max[k] = 0.1f;
  EXPECT_FALSE(predict_view(points.viewable(k), T_cw, T_cw.centre(), scene.camera, *view.features));
}

}  // namespace
}  // namespace covis
