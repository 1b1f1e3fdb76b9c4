// SPDX-License-Identifier: Apache-2.0
#include "covis/slam/mapper.h"

#include <gmock/gmock.h>

#include "covis/matching/point_geometry.h"
#include "covis/slam/test_frames.h"

namespace covis {
namespace {

SystemOptions options_of(Sensor sensor) {
  SystemOptions options;
  options.sensor = sensor;
  return options;
}

class MapperTest : public testing::Test {
 protected:
  // Frame i as a key frame at its true pose, seeing every `keep`-th point of `from`.
  KeyFrameRequest request(int i, KeyFrameId from = {}, int keep = 1, bool new_points = false) {
    KeyFrameRequest r;
    r.frame = i;
    r.stamp = frames.stamp(i);
    r.features = frames.features(i);
    r.pose.T_cr = frames.T_cw(i);
    r.points.resize(static_cast<size_t>(r.features->size()));
    if (from.valid()) {
      const auto map = shared.read();
      r.points = points_seen(*map, from, *r.features, frames.T_cw(i), keep);
      r.pose.key_frame = from;
      r.pose.T_cr = frames.T_cw(i) * map->at(from).T_cw.inverse();
    }
    if (new_points) r.new_points = features_with_depth(*r.features);
    return r;
  }
  MappingReport process(const KeyFrameRequest& r, const std::atomic<bool>* interrupt = nullptr) {
    const MappingReport report = mapper.process(r, interrupt);
    EXPECT_EQ(shared.read()->check(), "");
    return report;
  }
  size_t observations() {
    size_t count = 0;
    shared.read()->for_each_point([&](MapPointId, const MapPoint& p) { count += p.observations.size(); });
    return count;
  }

  TestFrames& frames = TestFrames::of(Sensor::rgbd);
  SharedMap shared{frames.camera()};
  Mapper mapper{shared, options_of(Sensor::rgbd)};
};

TEST_F(MapperTest, TheFirstKeyFramesPointsLieAtTheirDepth) {
  const MappingReport report = process(request(0, {}, 1, true));
  ASSERT_TRUE(report.key_frame.valid());
  EXPECT_EQ(report.frame, 0);
  const auto map = shared.read();
  EXPECT_EQ(map->root(), report.key_frame);
  const Features& f = *map->at(report.key_frame).features;
  ASSERT_GT(map->point_count(), 300u);
  EXPECT_EQ(map->point_count(), features_with_depth(f).size());
  map->for_each_point([&](MapPointId, const MapPoint& p) {
    const uint32_t feature = p.observations[0].feature;
    EXPECT_LT((p.position_w - unproject_depth(map->camera(), f, feature)).norm(), 1e-9);
    EXPECT_EQ(p.descriptor, f.descriptor[feature]);
  });
}

TEST_F(MapperTest, APoseIsRelativeToWhereItsReferenceIsNow) {
  const KeyFrameId first = process(request(0, {}, 1, true)).key_frame;
  const KeyFrameRequest second = request(4, first);
  const SE3 moved(so3_exp({0, 0.1, 0}), Eigen::Vector3d(1, 2, 3));
  ASSERT_TRUE(shared.write()->set_pose(first, moved));
  const KeyFrameId id = process(second).key_frame;
  const SE3 expected = frames.T_cw(4) * moved;
  EXPECT_LT((shared.read()->at(id).T_cw.t() - expected.t()).norm(), 1e-9);
}

TEST_F(MapperTest, AReferenceThatNeverWasIsRefused) {
  KeyFrameRequest r = request(0, {}, 1, true);
  r.pose.key_frame = {77, 3};
  EXPECT_FALSE(process(r).key_frame.valid());
  EXPECT_EQ(shared.read()->key_frame_count(), 0u);
}

TEST_F(MapperTest, FusionJoinsPointsThatWereNotMatched) {
  const KeyFrameId first = process(request(0, {}, 1, true)).key_frame;
  const size_t before = observations();
  const KeyFrameRequest r = request(3, first, 2);
  const auto given =
      static_cast<size_t>(std::count_if(r.points.begin(), r.points.end(), [](MapPointId id) { return id.valid(); }));
  ASSERT_GT(given, 30u);
  const MappingReport report = process(r);
  EXPECT_GT(report.points_fused, static_cast<int>(given) / 4) << "the other half is there to be found";
  EXPECT_GT(observations(), before + given);
}

TEST_F(MapperTest, FusionMergesTwoPointsOfOnePlace) {
  const KeyFrameId first = process(request(0, {}, 1, true)).key_frame;
  KeyFrameRequest r = request(3, first, 2);
  size_t doubles = 0;
  for (const uint32_t feature : features_with_depth(*r.features)) {
    if (r.points[feature].valid()) continue;
    r.new_points.push_back(feature);
    ++doubles;
  }
  const size_t before = shared.read()->point_count();
  const MappingReport report = process(r);
  EXPECT_GT(report.points_fused, 20);
  EXPECT_LT(shared.read()->point_count(), before + doubles);
}

TEST_F(MapperTest, PointsNeverFoundAgainAreCulled) {
  const KeyFrameId first = process(request(0, {}, 1, true)).key_frame;
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
  const MappingReport report = process(r);
  EXPECT_GE(report.points_culled, 10);
  for (const MapPointId id : rare) EXPECT_EQ(shared.read()->find(id), nullptr);
  EXPECT_GT(shared.read()->point_count(), 200u) << "the others stay";
}

TEST_F(MapperTest, KeyFramesThatTellNothingNewAreCulled) {
  const KeyFrameId first = process(request(0, {}, 1, true)).key_frame;
  int culled = 0;
  // The same view again and again.
  for (int k = 0; k < 6; ++k) culled += process(request(0, first)).key_frames_culled;
  EXPECT_GE(culled, 1);
  EXPECT_TRUE(shared.read()->find(first)) << "the root stays";
  EXPECT_EQ(shared.read()->key_frame_count(), static_cast<size_t>(7 - culled));
}

TEST_F(MapperTest, AnInterruptSkipsAdjustment) {
  const KeyFrameId first = process(request(0, {}, 1, true)).key_frame;
  process(request(4, first));
  const std::atomic<bool> stop{true}, go{false};
  EXPECT_EQ(process(request(8, first), &stop).ba_observations, 0);
  EXPECT_GT(process(request(12, first), &go).ba_observations, 0);
}

TEST_F(MapperTest, AdjustmentBringsADisturbedKeyFrameBack) {
  const KeyFrameId first = process(request(0, {}, 1, true)).key_frame;
  process(request(4, first));
  KeyFrameRequest r = request(8, first);
  r.pose.T_cr = SE3(so3_exp({0.002, -0.003, 0.001}), Eigen::Vector3d(0.01, 0.005, -0.01)) * r.pose.T_cr;
  const KeyFrameId id = process(r).key_frame;
  EXPECT_LT((shared.read()->at(id).T_cw.inverse().t() - frames.T_cw(8).inverse().t()).norm(), 0.005);
}

TEST_F(MapperTest, APartThatIsDiscardedIsForgotten) {
  const KeyFrameId first = process(request(0, {}, 1, true)).key_frame;
  const uint32_t submap = shared.read()->at(first).submap;
  mapper.discard(submap);
  EXPECT_EQ(shared.read()->key_frame_count(), 0u);
  EXPECT_EQ(shared.read()->point_count(), 0u);
  EXPECT_FALSE(process(request(4, {})).key_frame == first);
}

TEST_F(MapperTest, WithoutAReferenceAPartOfItsOwnIsBegun) {
  const KeyFrameId old = process(request(0, {}, 1, true)).key_frame;
  const KeyFrameId first = process(request(12, {}, 1, true)).key_frame;
  const KeyFrameId second = process(request(16, first)).key_frame;
  {
    const auto map = shared.read();
    EXPECT_EQ(map->check(), "");
    ASSERT_EQ(map->submaps().size(), 2u);
    EXPECT_TRUE(map->is_root(first));
    EXPECT_EQ(map->at(second).submap, map->at(first).submap);
  }
  const uint32_t submap = shared.read()->at(first).submap;
  mapper.discard(submap);
  EXPECT_NE(shared.read()->find(old), nullptr) << "nothing else is thrown away";
  EXPECT_EQ(shared.read()->find(first), nullptr);
  EXPECT_EQ(shared.read()->check(), "");
  KeyFrameRequest late = request(20, old);
  late.pose.key_frame = first;
  EXPECT_FALSE(process(late).key_frame.valid()) << "asked for beside what is gone";
}

// Two views of one camera, and as yet no points.
InitialMapRequest two_views(int second) {
  TestFrames& mono = TestFrames::of(Sensor::monocular);
  InitialMapRequest r;
  r.first = {0, mono.stamp(0), mono.features(0)};
  r.second = {second, mono.stamp(second), mono.features(second)};
  r.T_21 = mono.T_cw(second);
  return r;
}

// Points of the first view by the depth sensor's word, found in the second by their place.
void add_true_points(InitialMapRequest& r) {
  SharedMap true_map(TestFrames::of(Sensor::rgbd).camera());
  Mapper true_mapper(true_map, options_of(Sensor::rgbd));
  KeyFrameRequest with_depth;
  with_depth.features = TestFrames::of(Sensor::rgbd).features(0);
  with_depth.points.resize(static_cast<size_t>(with_depth.features->size()));
  with_depth.new_points = features_with_depth(*with_depth.features);
  const KeyFrameId from = true_mapper.process(with_depth, nullptr).key_frame;
  const auto map = true_map.read();
  const auto in_first = points_seen(*map, from, *r.first.features, SE3());
  const auto in_second = points_seen(*map, from, *r.second.features, r.T_21, 2);
  for (uint32_t i = 0; i < in_first.size(); ++i) {
    for (uint32_t j = 0; in_first[i].valid() && j < in_second.size(); ++j) {
      if (in_first[i] == in_second[j]) r.points.push_back({map->at(in_first[i]).position_w, i, j});
    }
  }
}

// Two views and no depth: an initial map, then points by triangulation with a third.
TEST(MonocularMapper, MakesAMapOfMedianDepthOneAndTriangulatesMore) {
  TestFrames& mono = TestFrames::of(Sensor::monocular);
  SharedMap shared(mono.camera());
  Mapper mapper(shared, options_of(Sensor::monocular));
  InitialMapRequest r = two_views(6);
  add_true_points(r);
  ASSERT_GT(r.points.size(), 80u);
  const MappingReport start = mapper.initialise(r);
  ASSERT_TRUE(start.key_frame.valid());
  ASSERT_TRUE(start.first.valid());
  EXPECT_EQ(shared.read()->check(), "");
  std::vector<double> depths;
  shared.read()->for_each_point([&](MapPointId, const MapPoint& p) { depths.push_back(p.position_w.z()); });
  std::nth_element(depths.begin(), depths.begin() + static_cast<ptrdiff_t>(depths.size() / 2), depths.end());
  EXPECT_NEAR(depths[depths.size() / 2], 1, 0.05);

  const double scale = shared.read()->at(start.key_frame).T_cw.t().norm() / r.T_21.t().norm();
  constexpr int kThird = 12;
  KeyFrameRequest third;
  third.frame = kThird;
  third.stamp = mono.stamp(kThird);
  third.features = mono.features(kThird);
  const SE3 T_cw(mono.T_cw(kThird).R(), Eigen::Vector3d(mono.T_cw(kThird).t() * scale));
  {
    const auto map = shared.read();
    third.pose.key_frame = start.key_frame;
    third.pose.T_cr = T_cw * map->at(start.key_frame).T_cw.inverse();
    third.points = points_seen(*map, start.key_frame, *third.features, T_cw);
  }
  const MappingReport report = mapper.process(third, nullptr);
  ASSERT_TRUE(report.key_frame.valid());
  EXPECT_GT(report.points_created, 20);
  EXPECT_EQ(shared.read()->check(), "");
  EXPECT_LT((shared.read()->at(report.key_frame).T_cw.inverse().t() - T_cw.inverse().t()).norm(), 0.02);
}

TEST(MonocularMapper, AnInitialMapOfWrongMatchesIsRefusedAndLeavesNothing) {
  SharedMap shared(TestFrames::of(Sensor::monocular).camera());
  Mapper mapper(shared, options_of(Sensor::monocular));
  InitialMapRequest r = two_views(6);
  for (uint32_t i = 0; i < 150; ++i) r.points.push_back({{0, 0, 1}, i, 400 - i});
  EXPECT_FALSE(mapper.initialise(r).key_frame.valid());
  EXPECT_EQ(shared.read()->key_frame_count(), 0u);
  EXPECT_EQ(shared.read()->point_count(), 0u);
}

}  // namespace
}  // namespace covis
