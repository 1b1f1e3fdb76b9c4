// SPDX-License-Identifier: Apache-2.0
#include "covis/mapping/point_creation.h"

#include <gtest/gtest.h>

#include "covis/map/test_point_scene.h"

namespace covis {
namespace {

// Two key frames that see the same without a point.
struct PointCreationTest : testing::Test {
  KeyFrameView view(size_t i, Sensor sensor) const {
    KeyFrameView made;
    made.id = {static_cast<uint32_t>(i), 0};
    made.T_cw = scene.T_cw(i);
    made.features = scene.view(scene.T_cw(i), sensor, i).features;
    made.points.resize(static_cast<size_t>(made.features->size()));
    made.positions.resize(made.points.size());
    return made;
  }
  std::vector<TriangulatedPoint> triangulate(Sensor sensor, const KeyFrameView& current,
                                             const std::vector<KeyFrameView>& neighbours) const {
    PointTriangulation triangulation(scene.camera, sensor, current);
    for (const KeyFrameView& neighbour : neighbours) triangulation.add(neighbour);
    return triangulation.made();
  }
  void expect_true(const std::vector<TriangulatedPoint>& made, size_t i) const {
    const PointScene::View seen = scene.view(scene.T_cw(i), Sensor::rgbd, i);
    for (const TriangulatedPoint& point : made)
      EXPECT_LT((point.position_w - scene.points[seen.point[point.feature]].position_w).norm(), 0.02);
  }

  const PointScene scene = PointScene::wall();
};

TEST_F(PointCreationTest, TriangulatesWhereThePointsAre) {
  const auto made = triangulate(Sensor::monocular, view(4, Sensor::monocular), {view(0, Sensor::monocular)});
  EXPECT_GT(made.size(), 50u);
  expect_true(made, 4);
}

TEST_F(PointCreationTest, AFeatureGetsOnePointThoughManyShowIt) {
  const auto made = triangulate(Sensor::rgbd, view(4, Sensor::rgbd), {view(0, Sensor::rgbd), view(2, Sensor::rgbd)});
  expect_true(made, 4);
  std::vector<uint32_t> features;
  for (const TriangulatedPoint& point : made) features.push_back(point.feature);
  std::sort(features.begin(), features.end());
  EXPECT_EQ(std::adjacent_find(features.begin(), features.end()), features.end());
}

TEST_F(PointCreationTest, NeighboursTooNearArePassedOver) {
  KeyFrameView beside = view(4, Sensor::rgbd);
  beside.T_cw = SE3(Eigen::Matrix3d::Identity(), Eigen::Vector3d(-0.05, 0, 0)) * beside.T_cw;
  EXPECT_TRUE(triangulate(Sensor::rgbd, view(4, Sensor::rgbd), {beside}).empty()) << "half a baseline";
}

}  // namespace
}  // namespace covis
