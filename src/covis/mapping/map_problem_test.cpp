// SPDX-License-Identifier: Apache-2.0
#include "covis/mapping/map_problem.h"

#include <gtest/gtest.h>

#include "covis/map/test_point_scene.h"
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
