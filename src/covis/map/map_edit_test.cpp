// SPDX-License-Identifier: Apache-2.0
#include "covis/map/map_edit.h"

#include <gtest/gtest.h>

#include "covis/map/test_map.h"

namespace covis {
namespace {

struct MapEditTest : testing::Test {
  void SetUp() override {
    for (const double x : {-1.0, 0.0, 1.0}) frames.push_back(f.frame(x));
    f.map.attach_to_tree(frames[1]);
    f.map.attach_to_tree(frames[2]);
  }
  // The same as a refresh would make of it.
  void expect_fresh(MapPointId id) {
    const MapPoint before = f.map.at(id);
    f.map.refresh_point(id);
    const MapPoint& after = f.map.at(id);
    EXPECT_EQ(before.normal_w, after.normal_w);
    EXPECT_EQ(before.d_max, after.d_max);
    EXPECT_EQ(before.descriptor, after.descriptor);
  }

  MapFixture f;
  std::vector<KeyFrameId> frames;
};

TEST_F(MapEditTest, RefreshesTheObservedPointsAtItsEnd) {
  MapPointId p;
  {
    MapEdit edit(f.map);
    p = edit.add_point({0, 0, 4}, frames[0], 0);
    EXPECT_TRUE(edit.add_observation(p, frames[1], 1));
    EXPECT_TRUE(edit.add_observation(p, frames[2], 2));
    EXPECT_FALSE(edit.add_observation(p, frames[2], 3));
    EXPECT_LT(edit->at(p).normal_w.dot(Eigen::Vector3d(0, 0, 1)), 0.999) << "not yet";
  }
  EXPECT_NEAR(f.map.at(p).normal_w.x(), 0, 1e-12);
  expect_fresh(p);
}

TEST_F(MapEditTest, APointThatMovedKeepsItsDescriptor) {
  const MapPointId p = f.map.add_point({0, 0, 4}, frames[0], 0);
  f.map.add_observation(p, frames[1], 1);
  f.map.add_observation(p, frames[2], 2);
  const Descriptor descriptor = f.map.at(p).descriptor;
  const float d_max = f.map.at(p).d_max;
  {
    MapEdit edit(f.map);
    EXPECT_TRUE(edit.set_position(p, {0, 0, 8}));
    EXPECT_TRUE(edit.erase_observation(p, frames[2]));
  }
  EXPECT_GT(f.map.at(p).d_max, 1.5f * d_max);
  EXPECT_EQ(f.map.at(p).descriptor, descriptor);
}

TEST_F(MapEditTest, ReplacedAndErasedPointsAreNoHarm) {
  const MapPointId p = f.map.add_point({0, 0, 4}, frames[0], 0), q = f.map.add_point({0, 0, 4}, frames[1], 1),
                   r = f.map.add_point({0, 0, 4}, frames[2], 2);
  {
    MapEdit edit(f.map);
    edit.set_position(p, {0, 0, 5});
    EXPECT_TRUE(edit.replace_point(p, q));
    EXPECT_FALSE(edit.erase_observation(p, frames[0]));
    EXPECT_TRUE(edit.erase_observation(r, frames[2]));
  }
  EXPECT_EQ(f.map.find(p), nullptr);
  EXPECT_EQ(f.map.find(r), nullptr);
  expect_fresh(q);
  EXPECT_EQ(f.map.check(), "");
}

TEST_F(MapEditTest, PointsTouchedElsewhereAreRefreshedOnDemand) {
  const MapPointId p = f.map.add_point({0, 0, 4}, frames[0], 0), q = f.map.add_point({0, 0, 4}, frames[1], 3);
  f.map.add_observation(p, frames[1], 1);
  f.map.add_observation(p, frames[2], 2);
  f.map.add_observation(q, frames[0], 3);
  const Eigen::Vector3d normal = f.map.at(q).normal_w;
  SharedMap shared;
  *shared.write() = std::move(f.map);
  refresh_points_of(shared, std::vector{frames[2]});
  f.map = std::move(*shared.write());
  EXPECT_EQ(f.map.at(q).normal_w, normal) << "not seen from there";
  expect_fresh(p);
}

TEST(MapEdit, HoldsTheGuardUntilItEnds) {
  SharedMap shared;
  KeyFrameId id;
  {
    MapEdit edit(shared);
    id = edit.map().begin_submap(0, 0, SE3(), std::make_shared<Features>(no_features()));
  }
  EXPECT_NE(shared.read()->find(id), nullptr);
}

}  // namespace
}  // namespace covis
