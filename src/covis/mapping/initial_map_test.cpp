// SPDX-License-Identifier: Apache-2.0
#include "covis/mapping/initial_map.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "covis/map/test_point_scene.h"

namespace covis {
namespace {

// Two views of a monocular camera, matched where both show a point.
struct InitialMapTest : testing::Test {
  static constexpr size_t kSecond = 4;   // view of the scene's path; the first is view 0, whose camera is the world
  static constexpr double kUnit = 0.37;  // the request's unit of length: any
  void SetUp() override {
    const PointScene::View a = scene.view(scene.T_cw(0), Sensor::monocular, 0);
    const PointScene::View b = scene.view(scene.T_cw(kSecond), Sensor::monocular, 1);
    request.first = {0, 0, a.features};
    request.second = {1, 1, b.features};
    request.T_21 = SE3(scene.T_cw(kSecond).R(), Eigen::Vector3d(kUnit * scene.T_cw(kSecond).t()));
    for (uint32_t i = 0; i < a.point.size(); ++i) {
      const auto at = std::find(b.point.begin(), b.point.end(), a.point[i]);
      if (at == b.point.end()) continue;
      const auto j = static_cast<uint32_t>(at - b.point.begin());
      request.points.push_back({kUnit * scene.points[a.point[i]].position_w, i, j});
    }
    ASSERT_GT(request.points.size(), 150u);
  }
  std::optional<InitialMap> make() { return make_initial_map(shared, request, adjuster, recent); }

  const PointScene scene = PointScene::wall();
  SharedMap shared{scene.camera};
  InitialMapRequest request;
  BundleAdjuster adjuster;
  RecentPoints recent;
};

TEST_F(InitialMapTest, ASubmapOfTwoKeyFramesWithAMedianDepthOfOne) {
  const std::optional<InitialMap> made = make();
  ASSERT_TRUE(made);
  const auto map = shared.read();
  EXPECT_EQ(map->check(), "");
  EXPECT_EQ(map->key_frame_count(), 2u);
  EXPECT_EQ(map->at(made->second).parent, made->first);
  EXPECT_EQ(map->point_count(), static_cast<size_t>(made->points));
  EXPECT_EQ(recent.size(), map->point_count()) << "they are on probation";
  std::vector<double> depths, truth;
  map->for_each_point([&](MapPointId, const MapPoint& point) { depths.push_back(point.position_w.z()); });
  for (const InitialMapRequest::Point& point : request.points) truth.push_back(point.position_w.z() / kUnit);
  ASSERT_EQ(depths.size(), truth.size()) << "without noise all survive";
  std::sort(depths.begin(), depths.end());
  std::sort(truth.begin(), truth.end());
  EXPECT_NEAR(depths[depths.size() / 2], 1, 1e-9);
  const double way = scene.T_cw(kSecond).t().norm() / truth[truth.size() / 2];
  EXPECT_NEAR(map->at(made->second).T_cw.t().norm(), way, 1e-3 * way);
}

TEST_F(InitialMapTest, WrongMatchesMakeNoMap) {
  for (size_t k = 0; k + 1 < request.points.size(); ++k)
    std::swap(request.points[k].feature_second, request.points[k + 1].feature_second);
  EXPECT_FALSE(make());
  EXPECT_EQ(shared.read()->key_frame_count(), 0u);
  EXPECT_EQ(recent.size(), 0u);
}

}  // namespace
}  // namespace covis
