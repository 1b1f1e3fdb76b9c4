// SPDX-License-Identifier: Apache-2.0
#include "covis/matching/expected_matches.h"

#include <gtest/gtest.h>

#include "covis/map/test_point_scene.h"

namespace covis {
namespace {

TEST(ExpectedMatches, CountsPointsByTheNearestViewTheyWereSeenFrom) {
  const PointScene scene = PointScene::wall();
  SceneMap world(scene);
  world.add_key_frames(1);
  const auto map = world.shared.write();
  const std::vector<MapPointId> points = map->points();
  // Three known well, of which two of three frames matched the first; one is young.
  for (size_t k = 0; k < 3; ++k) {
    map->count_visible(points[k], 8);
    map->count_found(points[k], k == 0 ? 5 : 8);
  }
  const Eigen::Vector3d here = map->at(world.frames[0]).T_cw.centre();
  const auto count = [&](const Eigen::Vector3d& centre) {
    ExpectedMatches expected;
    for (size_t k = 0; k < 4; ++k) expected.add(map->at(points[k]), *map, centre, k != 1);
    return expected;
  };
  const ExpectedMatches same = count(here);
  EXPECT_NEAR(same.from_here.expected, 2 + 6.0 / 9, 1e-9);
  EXPECT_EQ(same.from_here.found, 2);
  EXPECT_EQ(same.from_near.found, 2);
  EXPECT_NEAR(same.young_too.expected, 3 + 6.0 / 9, 1e-9);
  EXPECT_EQ(same.young_too.found, 3);
  const ExpectedMatches beside = count(here + Eigen::Vector3d(0, 1, 0));  // some 10 degrees
  EXPECT_EQ(beside.from_here.expected, 0);
  EXPECT_GT(beside.from_near.expected, 2);
  EXPECT_EQ(count(here + Eigen::Vector3d(0, 30, 0)).young_too.expected, 0);
}

TEST(ExpectedMatches, AFewSayNothing) {
  MatchTally tally{.expected = 59, .found = 10};
  EXPECT_FALSE(tally.enough());
  tally.expected = 100;
  EXPECT_TRUE(tally.enough());
  EXPECT_TRUE(tally.reaches(0.1));
  EXPECT_FALSE(tally.reaches(0.11));
}

}  // namespace
}  // namespace covis
