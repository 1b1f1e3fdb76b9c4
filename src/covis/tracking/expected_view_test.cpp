// SPDX-License-Identifier: Apache-2.0
#include "covis/tracking/expected_view.h"

#include <gtest/gtest.h>

#include <numeric>

#include "covis/tracking/test_frame.h"

namespace covis {
namespace {

// A wall of points, 4 to 8 metres away, that a camera knows.
class ExpectedViewTest : public testing::Test {
 protected:
  ExpectedViewTest() {
    world.add_key_frames(3, 0, 2);
    local_map.update(*world.shared.read(), {}, world.shared.read()->key_frames().front(), 10);
    in_view.assign(local_map.points.size(), 1);
  }
  int expected() const { return std::accumulate(view.points().begin(), view.points().end(), 0); }
  // The wall with everything in the left half of the image at this depth.
  TrackedFrame with_a_box_at(float depth) const {
    return frame_of(edited(scene.view(scene.T_cw(1)),
                           [&](Features& f) {
                             for (size_t i = 0; i < f.depth.size(); ++i) f.depth[i] = f.x[i] < 320 ? depth : 9.0f;
                           }),
                    scene.T_cw(1));
  }

  const PointScene scene = PointScene::wall(2400);
  SceneMap world{scene};
  LocalMap local_map;
  std::vector<uint8_t> in_view;
  ExpectedView view;
};

TEST_F(ExpectedViewTest, AllPointsInViewAreExpectedWhereNothingCoversThem) {
  const double matches = view.look(local_map, in_view, with_a_box_at(9), scene.camera);
  EXPECT_EQ(expected(), local_map.size());
  EXPECT_GT(matches, 0.5 * local_map.size());
  EXPECT_LE(matches, local_map.size());
}

TEST_F(ExpectedViewTest, PointsBehindSomethingNearerAreNotExpected) {
  view.look(local_map, in_view, with_a_box_at(1), scene.camera);
  EXPECT_LT(expected(), 0.7 * local_map.size());
  EXPECT_GT(expected(), 0.3 * local_map.size());
  for (size_t k = 0; k < local_map.points.size(); ++k) {
    const Eigen::Vector3d p_c = scene.T_cw(1) * local_map.points.position(k);
    const bool right = scene.camera.fx * p_c.x() / p_c.z() > 30;
    EXPECT_TRUE(!right || view.points()[k]) << "on the right nothing is covered";
  }
}

TEST_F(ExpectedViewTest, WhatIsOnlySomewhatNearerCoversNothing) {
  view.look(local_map, in_view, with_a_box_at(6), scene.camera);
  EXPECT_EQ(expected(), local_map.size());
}

TEST_F(ExpectedViewTest, PointsOutOfViewAreNeverExpected) {
  in_view.assign(local_map.points.size(), 0);
  EXPECT_EQ(view.look(local_map, in_view, with_a_box_at(9), scene.camera), 0);
  EXPECT_EQ(expected(), 0);
}

TEST_F(ExpectedViewTest, MatchedPointsShowHowFarOneSeesWithoutDepth) {
  const PointScene::View seen =
      edited(scene.view(scene.T_cw(1)), [](Features& f) { std::fill(f.depth.begin(), f.depth.end(), -1.0f); });
  TrackedFrame frame = frame_of(seen, scene.T_cw(1));
  for (size_t f = 0; f < seen.point.size(); ++f) {  // something a metre away has been matched everywhere
    const Eigen::Vector3d p_c = frame.T_cw * scene.points[seen.point[f]].position_w;
    frame.set_match(f, {static_cast<uint32_t>(f), 0}, frame.T_cw.inverse() * (p_c / p_c.z()), PointSource::map);
  }
  view.look(local_map, in_view, frame, scene.camera);
  EXPECT_LT(expected(), 0.2 * local_map.size());
}

}  // namespace
}  // namespace covis
