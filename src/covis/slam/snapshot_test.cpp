// SPDX-License-Identifier: Apache-2.0
#include "covis/slam/snapshot.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <type_traits>

#include "covis/map/test_map.h"

namespace covis {
namespace {

static_assert(std::is_same_v<decltype(std::declval<const SnapshotSource&>().get()), std::shared_ptr<const Snapshot>>,
              "a snapshot can't be changed by those who hold it");

// Submap 0 with two key frames and five points, submap 1 with one key frame and none.
class SnapshotTest : public testing::Test {
 protected:
  void SetUp() override {
    MapFixture made;
    a = made.frame(0);
    b = made.frame(1);
    made.link(a, b, 5, 0);
    c = made.map.begin_submap(20, 200, pose_at(2), made.features(400, false));
    *shared.write() = std::move(made.map);
  }
  void append(int64_t frame, KeyFrameId reference) {
    const uint32_t submap = shared.read()->at(reference).submap;
    log.append({.frame = frame,
                .stamp = 10 * frame,
                .pose = RelativePose{reference, 1, pose_at(0.5)},
                .online = SubmapPose{pose_at(7).inverse(), submap}});
  }

  KeyFrameId a, b, c;
  SharedMap shared;
  TrajectoryLog log;
  SnapshotSource source{shared, log};
};

// Equal cameras, which a map may hold twice, are one.
TEST_F(SnapshotTest, KeyFramesNameTheOtherCamerasThatMadeThem) {
  const RefinedCamera wide{{1280, 720, {900, 901, 640, 360}}, {890, 891, 640, 360}};
  MapFixture made;
  const auto by_wide = [&] {
    auto features = std::make_shared<Features>(*made.features(400, false));
    features->made_by = std::make_shared<const RefinedCamera>(wide);
    return features;
  };
  const KeyFrameId first = made.frame(0), second = made.map.add_key_frame(10, 0, pose_at(1), by_wide());
  made.link(first, second, 5, 0);
  made.map.begin_submap(20, 200, pose_at(2), by_wide());
  *shared.write() = std::move(made.map);
  const auto snapshot = source.get();
  EXPECT_EQ(snapshot->other_cameras, std::vector{wide});
  EXPECT_EQ(snapshot->key_frames[0].camera, 0u);
  EXPECT_EQ(snapshot->key_frames[1].camera, 1u);
  EXPECT_EQ(snapshot->key_frames[2].camera, 1u);
}

TEST_F(SnapshotTest, HasWhatMapAndLogHave) {
  append(3, b);
  log.append({.frame = 4, .stamp = 40, .pose = {}, .online = {}});
  const auto snapshot = source.get();
  ASSERT_EQ(source.trajectory().size(), 1u);
  EXPECT_EQ(source.trajectory()[0].T_wc.t(), snapshot->trajectory.at(0).T_wc.t());
  ASSERT_EQ(snapshot->key_frames.size(), 3u);
  EXPECT_EQ(snapshot->key_frames[1].id, b);
  EXPECT_EQ(snapshot->key_frames[1].parent, a);
  EXPECT_FALSE(snapshot->key_frames[0].parent.valid());
  EXPECT_EQ(snapshot->key_frames[1].frame, 10);
  EXPECT_NEAR(snapshot->key_frames[1].T_wc.t().x(), 1, 1e-12);
  EXPECT_EQ(snapshot->key_frames[2].submap, 1u);
  EXPECT_EQ(snapshot->key_frames[2].stamp, 200);
  ASSERT_EQ(snapshot->points.size(), 5u);
  EXPECT_EQ(snapshot->points[4].position_w, Eigen::Vector3d(0, 0, 5));
  ASSERT_EQ(snapshot->trajectory.size(), 1u) << "frames without a pose are left out";
  EXPECT_EQ(snapshot->trajectory[0].frame, 3);
  EXPECT_EQ(snapshot->trajectory[0].stamp, 30);
  EXPECT_NEAR(snapshot->trajectory[0].T_wc.t().x(), 1.5, 1e-12);
  ASSERT_EQ(snapshot->online.size(), 1u);
  EXPECT_NEAR(snapshot->online[0].T_wc.t().x(), 7, 1e-12);
  EXPECT_EQ(snapshot->camera, shared.read()->camera());
}

TEST_F(SnapshotTest, FramesAreWhereTheRollingShutterThatWasFoundPutsThem) {
  append(3, b);
  FrameRecord record = *log.last();
  record.frame = 4;
  record.shutter.move << 100, 0, 0, 0, 0, 0;
  record.shutter.row_time = 1e-3;
  log.append(record);
  const double before = source.get()->trajectory[1].T_wc.t().x();
  EXPECT_NEAR(before - source.get()->trajectory[0].T_wc.t().x(), 0.1, 1e-6)
      << "the map's camera has no rolling shutter";
  Pinhole camera = shared.read()->camera();
  camera.row_time = 1e-3;
  shared.write()->set_camera(camera);
  EXPECT_EQ(source.get()->trajectory[1].T_wc.t(), source.get()->trajectory[0].T_wc.t())
      << "it was tracked with this one";
  camera.row_time = 3e-3;
  shared.write()->set_camera(camera);
  const auto snapshot = source.get();
  EXPECT_NEAR(snapshot->trajectory[1].T_wc.t().x() - snapshot->trajectory[0].T_wc.t().x(), -0.2, 1e-6);
  EXPECT_EQ(source.trajectory()[1].T_wc.t(), snapshot->trajectory[1].T_wc.t());
  log.anchor(4, RelativePose::at(*shared.read(), b));
  EXPECT_NEAR(source.get()->trajectory[1].T_wc.t().x(), 1, 1e-12) << "as a key frame it moved with the map";
}

TEST_F(SnapshotTest, EdgesAndObservationsReferToWhatIsListed) {
  {
    const auto map = shared.write();
    map->add_loop_edge(a, b);
  }
  const auto snapshot = source.get();
  ASSERT_EQ(snapshot->edges.size(), 1u) << "five shared points make no edge, but a loop does";
  EXPECT_EQ(snapshot->edges[0].a, 0u);
  EXPECT_EQ(snapshot->edges[0].b, 1u);
  EXPECT_EQ(snapshot->edges[0].shared, 5);
  EXPECT_TRUE(snapshot->edges[0].loop);
  ASSERT_EQ(snapshot->observations.size(), 10u);
  const auto map = shared.read();
  for (const MapSnapshot::Observation& o : snapshot->observations) {
    const KeyFrame& key_frame = map->at(snapshot->key_frames[o.key_frame].id);
    const auto at = std::find(key_frame.points.begin(), key_frame.points.end(), snapshot->points[o.point].id);
    ASSERT_NE(at, key_frame.points.end());
    EXPECT_EQ(o.u, key_frame.features->image_x()[static_cast<size_t>(at - key_frame.points.begin())]);
  }
}

TEST_F(SnapshotTest, AnEdgeOfALoopNeedsNoSharedPoints) {
  const KeyFrameId d = [&] {
    const auto map = shared.write();
    return map->add_key_frame(30, 300, pose_at(3), map->at(c).features, 1);
  }();
  shared.write()->add_loop_edge(c, d);
  const auto snapshot = source.get();
  ASSERT_EQ(snapshot->edges.size(), 1u);
  EXPECT_EQ(snapshot->edges[0].shared, 0);
  EXPECT_TRUE(snapshot->edges[0].loop);
}

TEST_F(SnapshotTest, SubmapsComeLoadedOnesFirstThenByFramesThenByAge) {
  const auto ids = [&] {
    std::vector<uint32_t> list;
    for (const SubmapSummary& submap : source.get()->submaps) list.push_back(submap.id);
    return list;
  };
  EXPECT_EQ(ids(), (std::vector<uint32_t>{0, 1})) << "the older one first";
  append(3, c);
  EXPECT_EQ(ids(), (std::vector<uint32_t>{1, 0})) << "the one with more frames first";
  EXPECT_EQ(source.get()->index_of(0), 1u);
  EXPECT_EQ(source.get()->index_of(2), std::nullopt);
  source.map_loaded(1);
  EXPECT_EQ(ids(), (std::vector<uint32_t>{0, 1})) << "the loaded one first";
  const auto snapshot = source.get();
  EXPECT_TRUE(snapshot->submaps[0].loaded);
  EXPECT_EQ(snapshot->submaps[0].key_frames, 2u);
  EXPECT_EQ(snapshot->submaps[0].points, 5u);
  EXPECT_EQ(snapshot->submaps[0].frames, 0u);
  EXPECT_EQ(snapshot->submaps[1].frames, 1u);
  EXPECT_EQ(poses_in(snapshot->trajectory, 1u).size(), 1u);
  EXPECT_TRUE(poses_in(snapshot->trajectory, 0u).empty());
}

TEST_F(SnapshotTest, IsMadeAnewWhenSomethingChangedOnly) {
  const auto first = source.get();
  (void)shared.read();
  EXPECT_EQ(source.get(), first);
  append(3, a);
  const auto longer = source.get();
  EXPECT_NE(longer, first);
  EXPECT_GT(longer->revision, first->revision);
  shared.write()->set_pose(b, pose_at(4));
  const auto moved = source.get();
  EXPECT_NEAR(moved->key_frames[1].T_wc.t().x(), 4, 1e-12);
  EXPECT_EQ(source.get(), moved);
  EXPECT_NEAR(longer->key_frames[1].T_wc.t().x(), 1, 1e-12) << "who holds an older one keeps it as it was";
  EXPECT_TRUE(first->trajectory.empty());
}

TEST_F(SnapshotTest, FramesOfAnErasedKeyFrameAreWhereTheMapHasThem) {
  append(3, a);
  append(4, b);
  append(5, b);
  append(6, a);
  const std::vector<FrameRecord> records = log.records();
  std::vector<Eigen::Vector3d> expected;
  {
    const auto map = shared.write();
    map->attach_to_tree(b);
    ASSERT_TRUE(map->erase_key_frame(b));
    map->correct_pose(a, pose_at(-2), 1.5);
    for (const FrameRecord& record : records) expected.push_back(record.pose->resolved(*map)->T_cw(*map).inverse().t());
  }
  const auto snapshot = source.get();
  ASSERT_EQ(snapshot->trajectory.size(), 4u);
  for (size_t k = 0; k < 4; ++k) EXPECT_EQ(snapshot->trajectory[k].T_wc.t(), expected[k]) << k;
  EXPECT_EQ(snapshot->submaps[*snapshot->index_of(0)].frames, 4u);
}

TEST_F(SnapshotTest, FramesOfAnErasedSubmapAreLeftOut) {
  append(3, c);
  shared.write()->erase_submap(1);
  const auto snapshot = source.get();
  EXPECT_TRUE(snapshot->trajectory.empty());
  EXPECT_EQ(snapshot->submaps.size(), 1u);
}

TEST_F(SnapshotTest, TheCameraIsThatOfTheMap) {
  const Pinhole other{400, 400, 320, 240, 0};
  shared.write()->set_camera(other);
  source.map_loaded(2);
  EXPECT_EQ(source.camera(), other);
  EXPECT_EQ(source.get()->camera, other);
}

TEST_F(SnapshotTest, PointsHaveTheMeanColourOfTheirObservers) {
  const auto paint = [&](KeyFrameId id, uint8_t red) {
    const size_t count = shared.read()->at(id).points.size();
    shared.write()->set_colours(id, std::make_shared<const std::vector<Colour>>(count, Colour{red, 0, 9}));
  };
  EXPECT_EQ(source.get()->points.at(0).colour, kNoColour);
  paint(a, 100);
  EXPECT_EQ(source.get()->points.at(0).colour, (Colour{100, 0, 9}));
  paint(b, 200);
  EXPECT_EQ(source.get()->points.at(4).colour, (Colour{150, 0, 9}));
}

}  // namespace
}  // namespace covis
