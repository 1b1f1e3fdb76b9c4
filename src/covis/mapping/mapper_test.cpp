// SPDX-License-Identifier: Apache-2.0
#include "covis/mapping/mapper.h"

#include <gmock/gmock.h>

#include <algorithm>

#include "covis/map/test_point_scene.h"
#include "covis/matching/point_geometry.h"

namespace covis {
namespace {

constexpr CloseDepth kCloseDepth{100};  // baselines, of 0.1 m: all points of the scene are close

class MapperTest : public testing::Test {
 protected:
  // View i as a key frame at its true pose, seeing every `keep`-th point of `from`.
  KeyFrameRequest request(size_t i, KeyFrameId from = {}, int keep = 1) {
    return scene_request(scene, shared, Sensor::rgbd, i, from, keep);
  }
  MapperReport process(const KeyFrameRequest& r, const std::atomic<bool>* interrupt = nullptr) {
    const MapperReport report = mapper.process(r, interrupt);
    EXPECT_EQ(shared.read()->check(), "");
    return report;
  }
  size_t observations() {
    size_t count = 0;
    shared.read()->for_each_point([&](MapPointId, const MapPoint& p) { count += p.observations.size(); });
    return count;
  }

  const PointScene scene = PointScene::wall(1200);
  SharedMap shared{scene.camera};
  Mapper mapper{shared, Sensor::rgbd, {}, kCloseDepth};
};

TEST_F(MapperTest, TheFirstKeyFramesPointsLieAtTheirDepth) {
  const MapperReport report = process(request(0));
  ASSERT_TRUE(report.key_frame.valid());
  EXPECT_EQ(report.frame, 0);
  const auto map = shared.read();
  EXPECT_EQ(map->root(), report.key_frame);
  const Features& f = *map->at(report.key_frame).features;
  ASSERT_GT(map->point_count(), 300u);
  EXPECT_EQ(map->point_count(), static_cast<size_t>(f.size())) << "all have depth";
  EXPECT_EQ(report.counts.points_created, f.size());
  map->for_each_point([&](MapPointId, const MapPoint& p) {
    const uint32_t feature = p.observations[0].feature;
    EXPECT_LT((p.position_w - unproject_depth(map->camera(), f, feature)).norm(), 1e-9);
    EXPECT_EQ(p.descriptor, f.descriptor[feature]);
  });
}

TEST_F(MapperTest, APoseIsRelativeToWhereItsReferenceIsNow) {
  const KeyFrameId first = process(request(0)).key_frame;
  const KeyFrameRequest second = request(4, first);
  const SE3 moved(so3_exp({0, 0.1, 0}), Eigen::Vector3d(1, 2, 3));
  ASSERT_TRUE(shared.write()->set_pose(first, moved));
  const KeyFrameId id = process(second).key_frame;
  const SE3 expected = scene.T_cw(4) * moved;
  EXPECT_LT((shared.read()->at(id).T_cw.t() - expected.t()).norm(), 1e-9);
}

TEST_F(MapperTest, AReferenceThatNeverWasIsRefused) {
  KeyFrameRequest r = request(0);
  r.pose.key_frame = {77, 3};
  EXPECT_FALSE(process(r).key_frame.valid());
  EXPECT_EQ(shared.read()->key_frame_count(), 0u);
}

TEST_F(MapperTest, FusionJoinsPointsThatWereNotMatched) {
  const KeyFrameId first = process(request(0)).key_frame;
  const size_t before = observations();
  const KeyFrameRequest r = request(3, first, 2);
  const auto given =
      static_cast<size_t>(std::count_if(r.points.begin(), r.points.end(), [](MapPointId id) { return id.valid(); }));
  ASSERT_GT(given, 30u);
  const MapperReport report = process(r);
  EXPECT_GT(report.counts.points_fused, static_cast<int>(given) / 4) << "the other half is there to be found";
  EXPECT_GT(observations(), before + given);
}

TEST_F(MapperTest, FusionMergesTwoPointsOfOnePlace) {
  const KeyFrameId first = process(request(0)).key_frame;
  KeyFrameRequest r = request(3, first, 2);
  size_t doubles = 0;
  for (uint32_t feature = 0; feature < r.points.size(); ++feature) {
    if (r.points[feature].valid()) continue;
    r.new_points.push_back(feature);
    ++doubles;
  }
  const size_t before = shared.read()->point_count();
  const MapperReport report = process(r);
  EXPECT_GT(report.counts.points_fused, 20);
  EXPECT_LT(shared.read()->point_count(), before + doubles);
}

TEST_F(MapperTest, PointsNeverFoundAgainAreCulled) {
  const KeyFrameId first = process(request(0)).key_frame;
  KeyFrameRequest r = request(2, first);
  std::vector<MapPointId> rare;
  {
    const auto map = shared.read();
    for (const MapPointId id : map->points()) {
      if (rare.size() == 10) break;
      rare.push_back(id);
    }
  }
  for (const MapPointId id : rare) r.counts.push_back({id, 20, 1});
  const MapperReport report = process(r);
  EXPECT_GE(report.counts.points_culled, 10);
  for (const MapPointId id : rare) EXPECT_EQ(shared.read()->find(id), nullptr);
  EXPECT_GT(shared.read()->point_count(), 200u) << "the others stay";
}

TEST_F(MapperTest, KeyFramesThatTellNothingNewAreCulled) {
  const KeyFrameId first = process(request(0)).key_frame;
  int culled = 0;
  // The same view again and again.
  for (int k = 0; k < 6; ++k) culled += process(request(0, first)).counts.key_frames_culled;
  EXPECT_GE(culled, 1);
  EXPECT_TRUE(shared.read()->find(first)) << "the root stays";
  EXPECT_EQ(shared.read()->key_frame_count(), static_cast<size_t>(7 - culled));
}

TEST_F(MapperTest, AnInterruptSkipsAdjustment) {
  const KeyFrameId first = process(request(0)).key_frame;
  process(request(4, first));
  const std::atomic<bool> stop{true}, go{false};
  EXPECT_EQ(process(request(8, first), &stop).adjustment.observations, 0);
  EXPECT_GT(process(request(12, first), &go).adjustment.observations, 0);
}

TEST_F(MapperTest, AdjustmentBringsADisturbedKeyFrameBack) {
  const KeyFrameId first = process(request(0)).key_frame;
  process(request(4, first));
  KeyFrameRequest r = request(8, first);
  r.pose.T_cr = SE3(so3_exp({0.002, -0.003, 0.001}), Eigen::Vector3d(0.01, 0.005, -0.01)) * r.pose.T_cr;
  const KeyFrameId id = process(r).key_frame;
  EXPECT_LT((shared.read()->at(id).T_cw.inverse().t() - scene.T_cw(8).inverse().t()).norm(), 0.005);
}

TEST_F(MapperTest, WithoutAReferenceASubmapOfItsOwnIsBegun) {
  const KeyFrameId old = process(request(0)).key_frame;
  const KeyFrameId first = process(request(6)).key_frame;
  const KeyFrameId second = process(request(8, first)).key_frame;
  {
    const auto map = shared.read();
    EXPECT_EQ(map->check(), "");
    ASSERT_EQ(map->submaps().size(), 2u);
    EXPECT_TRUE(map->is_root(first));
    EXPECT_EQ(map->at(second).submap, map->at(first).submap);
  }
  const uint32_t submap = shared.read()->at(first).submap;
  shared.write()->erase_submap(submap);
  EXPECT_NE(shared.read()->find(old), nullptr) << "nothing else is thrown away";
  EXPECT_EQ(shared.read()->find(first), nullptr);
  EXPECT_EQ(shared.read()->check(), "");
  KeyFrameRequest late = request(10, old);
  late.pose.key_frame = first;
  EXPECT_FALSE(process(late).key_frame.valid()) << "asked for beside what is gone";
}

class MonocularMapper : public testing::Test {
 protected:
  // Views 0 and `second`, and no points yet.
  InitialMapRequest two_views(size_t second) const {
    InitialMapRequest r;
    r.first = {0, 0, scene.view(scene.T_cw(0), Sensor::monocular, 0).features};
    const auto frame = static_cast<int64_t>(second);
    r.second = {frame, frame, scene.view(scene.T_cw(second), Sensor::monocular, second).features};
    r.T_21 = scene.T_cw(second);
    return r;
  }
  // Every other point that both views see, where it is.
  void add_true_points(InitialMapRequest& r) const {
    const auto first = scene.view(scene.T_cw(0), Sensor::monocular, 0).point;
    const auto second = scene.view(r.T_21, Sensor::monocular, 0).point;
    for (uint32_t i = 0; i < first.size(); i += 2) {
      const auto at = std::find(second.begin(), second.end(), first[i]);
      if (at == second.end()) continue;
      r.points.push_back({scene.points[first[i]].position_w, i, static_cast<uint32_t>(at - second.begin())});
    }
  }

  const PointScene scene = PointScene::wall(1200);
  SharedMap shared{scene.camera};
  Mapper mapper{shared, Sensor::monocular, {}, kCloseDepth};
};

// Two views and no depth: an initial map, then points by triangulation with a third.
TEST_F(MonocularMapper, MakesAMapOfMedianDepthOneAndTriangulatesMore) {
  InitialMapRequest r = two_views(3);
  add_true_points(r);
  ASSERT_GT(r.points.size(), 80u);
  const MapperReport start = mapper.initialise(r);
  ASSERT_TRUE(start.key_frame.valid());
  ASSERT_TRUE(start.first.valid());
  EXPECT_EQ(shared.read()->check(), "");
  std::vector<double> depths;
  shared.read()->for_each_point([&](MapPointId, const MapPoint& p) { depths.push_back(p.position_w.z()); });
  std::nth_element(depths.begin(), depths.begin() + static_cast<ptrdiff_t>(depths.size() / 2), depths.end());
  EXPECT_NEAR(depths[depths.size() / 2], 1, 0.05);

  const double scale = shared.read()->at(start.key_frame).T_cw.t().norm() / r.T_21.t().norm();
  constexpr size_t kThird = 6;
  KeyFrameRequest third = scene_request(scene, shared, Sensor::monocular, kThird, start.key_frame);
  const SE3 T_cw(scene.T_cw(kThird).R(), Eigen::Vector3d(scene.T_cw(kThird).t() * scale));
  third.pose = RelativePose::of(*shared.read(), T_cw, start.key_frame);
  const MapperReport report = mapper.process(third, nullptr);
  ASSERT_TRUE(report.key_frame.valid());
  EXPECT_GT(report.counts.points_created, 20);
  EXPECT_EQ(shared.read()->check(), "");
  EXPECT_LT((shared.read()->at(report.key_frame).T_cw.inverse().t() - T_cw.inverse().t()).norm(), 0.02);
}

TEST_F(MonocularMapper, AnInitialMapOfWrongMatchesIsRefusedAndLeavesNothing) {
  InitialMapRequest r = two_views(3);
  for (uint32_t i = 0; i < 150; ++i) r.points.push_back({{0, 0, 1}, i, 400 - i});
  EXPECT_FALSE(mapper.initialise(r).key_frame.valid());
  EXPECT_EQ(shared.read()->key_frame_count(), 0u);
  EXPECT_EQ(shared.read()->point_count(), 0u);
}

}  // namespace
}  // namespace covis
