// SPDX-License-Identifier: Apache-2.0
#include "covis/mapping/map_problem.h"

#include <gtest/gtest.h>

#include <cmath>

#include "covis/map/anchors.h"
#include "covis/map/test_point_scene.h"
#include "covis/matching/patch_alignment.h"
#include "covis/matching/point_set.h"

namespace covis {
namespace {

struct MapProblemTest : testing::Test {
  void SetUp() override { world.add_key_frames(5); }
  MapProblem gather(const std::vector<KeyFrameId>& frames, size_t moving) {
    MapProblem problem;
    problem.gather(*world.shared.read(), frames, moving);
    return problem;
  }
  std::vector<MapPointId> points_of_frames(const std::vector<KeyFrameId>& frames) {
    return points_of(*world.shared.read(), frames);
  }
  static SE3 pose_of_test() { return SE3::exp((Vector6d() << 0.1, 0.2, 0.3, 0, 0.1, 0).finished()); }

  const PointScene scene = PointScene::wall();
  SceneMap world{scene};
};

TEST_F(MapProblemTest, HoldsThePointsOfThoseThatMove) {
  const auto& k = world.frames;
  const MapProblem problem = gather({k[2], k[3], k[1]}, 2);
  EXPECT_EQ(problem.problem.fixed, (std::vector<uint8_t>{0, 0, 1}));
  EXPECT_EQ(problem.points, points_of_frames({k[2], k[3]}));
  const auto map = world.shared.read();
  size_t observations = 0;
  for (const MapPointId& id : problem.points) {
    for (const Observation& o : map->at(id).observations) observations += o.key_frame != k[0] && o.key_frame != k[4];
  }
  EXPECT_EQ(problem.problem.observations.size(), observations);
}

// Aligned observations of one anchor are close to each other; a single one is close to nothing.
TEST_F(MapProblemTest, ObservationsOfOneAnchorWeighMore) {
  const std::vector<KeyFrameId>& k = world.frames;
  const MapPointId pair = world.shared.read()->at(k[1]).points[0], alone = world.shared.read()->at(k[1]).points[1];
  const auto align = [&](MapPointId id, KeyFrameId view, uint64_t anchor) {
    const auto map = world.shared.write();
    auto features = map->at(view).features->for_key_frame();
    features->anchor.resize(features->x.size(), 0);
    features->anchor[map->at(id).feature_in(view)] = anchor;
    map->set_features(view, features);
  };
  const auto anchor_of_reference = [&](MapPointId id) {
    const auto map = world.shared.read();
    const MapPoint& point = map->at(id);
    return anchor_of(map->at(point.reference), point.feature_in(point.reference));
  };
  align(pair, k[1], anchor_of_reference(pair));
  align(pair, k[2], anchor_of_reference(pair));
  align(alone, k[1], anchor_of_reference(pair));  // a keypoint of the same key frame, but not its own
  const MapProblem problem = gather(k, k.size());
  const auto map = world.shared.read();
  int closer = 0;
  for (const BundleObservation& o : problem.problem.observations) {
    const MapPointId id = problem.points[static_cast<size_t>(o.point)];
    const KeyFrameId view = problem.key_frames[static_cast<size_t>(o.pose)];
    const Features& f = *map->at(view).features;
    const float weight = o.inv_sigma2 / f.pyramid->inv_sigma2[f.level[map->at(id).feature_in(view)]];
    const bool aligned = id == pair && (view == k[1] || view == k[2] || view == map->at(id).reference);
    EXPECT_FLOAT_EQ(weight, aligned ? aligned_weight(map->camera()) : 1);
    closer += aligned;
  }
  EXPECT_EQ(closer, 3);
}

// Where an image is bent by more than aligned places err, observations are left out but stay.
TEST_F(MapProblemTest, AlignedOutliersStayWhileTheyFitAsKeypoints) {
  MapProblem problem = gather(world.frames, world.frames.size());
  constexpr size_t kObservation = 5;
  BundleObservation& o = problem.problem.observations[kObservation];
  const KeyFrameId view = problem.key_frames[static_cast<size_t>(o.pose)];
  const MapPointId id = problem.points[static_cast<size_t>(o.point)];
  const auto is_seen_after = [&](bool aligned, float off) {
    problem.aligned[kObservation] = aligned;
    o.u += off;
    o.active = 0;
    {
      MapEdit edit(world.shared);
      problem.erase_outliers(edit);
    }
    o.u -= off;
    return world.shared.read()->at(id).seen_by(view);
  };
  o.inv_sigma2 *= aligned_weight(problem.problem.camera);
  const float sigma = std::sqrt(aligned_weight(problem.problem.camera) / o.inv_sigma2);
  EXPECT_TRUE(is_seen_after(true, 1.8f * sigma));
  EXPECT_FALSE(is_seen_after(false, 1.8f * sigma)) << "what is not aligned has one bound";
}

TEST_F(MapProblemTest, RootsStay) {
  EXPECT_EQ(gather({world.frames[0], world.frames[1]}, 2).problem.fixed, (std::vector<uint8_t>{1, 0}));
}

TEST_F(MapProblemTest, WritesBackWhatStillExists) {
  MapProblem problem = gather(world.frames, world.frames.size());
  problem.problem.poses[1] = pose_of_test();
  problem.problem.points[0] = {1, 2, 3};
  problem.problem.observations[5].active = 0;
  const auto outlier = problem.problem.observations[5];
  const KeyFrameId held = problem.key_frames[static_cast<size_t>(outlier.pose)];
  const MapPointId point = problem.points[static_cast<size_t>(outlier.point)];
  ASSERT_TRUE(world.shared.write()->erase_key_frame(world.frames[3]));
  {
    MapEdit edit(world.shared);
    problem.commit(edit);
  }
  const auto map = world.shared.read();
  EXPECT_EQ(map->check(), "");
  EXPECT_LT((map->at(world.frames[1]).T_cw.t() - pose_of_test().t()).norm(), 1e-9);
  EXPECT_EQ(map->at(problem.points[0]).position_w, Eigen::Vector3d(1, 2, 3));
  if (const MapPoint* left = map->find(point)) {
    for (const Observation& o : left->observations) EXPECT_NE(o.key_frame, held);
  }
}

}  // namespace
}  // namespace covis
