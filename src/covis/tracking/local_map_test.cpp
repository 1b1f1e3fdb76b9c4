// SPDX-License-Identifier: Apache-2.0
#include "covis/tracking/local_map.h"

#include <gmock/gmock.h>

#include "covis/core/random.h"
#include "covis/features/test_features.h"

namespace covis {
namespace {

using testing::ElementsAre;
using testing::UnorderedElementsAre;

// Five key frames in a row. 0-1 share 40 points, 1-2 share 30, 2-3 share 20; 4 is a child of 3 and shares nothing.
class LocalMapTest : public testing::Test {
 protected:
  LocalMapTest() {
    map.set_camera({500, 500, 320, 240, 40});
    for (int i = 0; i < 5; ++i) {
      frames.push_back(map.add_key_frame(i, i, SE3(Eigen::Matrix3d::Identity(), Eigen::Vector3d(-i, 0, 0)),
                                         random_features(random, 400, 2)));
    }
    share(0, 1, 40, 0);
    share(1, 2, 30, 100);
    share(2, 3, 20, 200);
    own = map.add_point({4, 0, 5}, frames[4], 300);
    for (size_t i = 1; i < 5; ++i) map.attach_to_tree(frames[i]);
  }

  void share(size_t a, size_t b, uint32_t count, uint32_t first) {
    for (uint32_t k = 0; k < count; ++k) {
      const MapPointId p = map.add_point({random.uniform(-1, 1), random.uniform(-1, 1), 5}, frames[a], first + k);
      ASSERT_TRUE(map.add_observation(p, frames[b], first + k));
      map.refresh_point(p);
      shared[a].push_back(p);
    }
  }

  Random random{1};
  Map map;
  std::vector<KeyFrameId> frames;
  std::vector<MapPointId> shared[3];
  MapPointId own;
  LocalMap local;
};

TEST_F(LocalMapTest, HoldsTheObserversTheirNeighboursAndTheTree) {
  local.update(map, shared[0], {}, 80);
  // K1: the observers 0 and 1, equal in votes, by handle; K2: what is covisible with them.
  EXPECT_THAT(local.key_frames, ElementsAre(frames[0], frames[1], frames[2]));
  EXPECT_EQ(local.reference.id, frames[0]);
  EXPECT_EQ(local.size(), 40 + 30 + 20) << "each point once";
  EXPECT_EQ(local.reference_points, 40);
  EXPECT_EQ(local.reference_all_points, 40);
}

TEST_F(LocalMapTest, PointsOfOneKeyFrameAreNew) {
  local.update(map, shared[2], {}, 80);
  EXPECT_FALSE(local.is_new(shared[2].front()));
  EXPECT_TRUE(local.is_new(own));
  EXPECT_FALSE(local.is_new({}));
  local.clear();
  EXPECT_FALSE(local.is_new(own));
}

TEST_F(LocalMapTest, MostVotesMakeTheReference) {
  std::vector<MapPointId> matched(shared[2].begin(), shared[2].end());
  matched.insert(matched.end(), shared[1].begin(), shared[1].begin() + 5);
  local.update(map, matched, {}, 80);
  EXPECT_EQ(local.reference.id, frames[2]) << "sees all of them, 3 and 1 only some";
  EXPECT_THAT(std::vector(local.key_frames.begin(), local.key_frames.begin() + 3),
              ElementsAre(frames[2], frames[3], frames[1]));
  EXPECT_THAT(local.key_frames, UnorderedElementsAre(frames[0], frames[1], frames[2], frames[3], frames[4]))
      << "0 is covisible with 1, 4 is a child of 3";
}

TEST_F(LocalMapTest, NoMoreKeyFramesThanAllowed) {
  local.update(map, shared[0], {}, 2);
  EXPECT_THAT(local.key_frames, ElementsAre(frames[0], frames[1]));
  EXPECT_EQ(local.size(), 70);
}

TEST_F(LocalMapTest, WithoutMatchesItLiesAroundTheFallback) {
  local.update(map, {}, frames[4], 80);
  EXPECT_THAT(local.key_frames, ElementsAre(frames[4], frames[3]));
  EXPECT_THAT(local.points.id, testing::Contains(own));
  local.update(map, {}, {}, 80);
  EXPECT_EQ(local.size(), 0);
  EXPECT_TRUE(local.key_frames.empty());
}

TEST_F(LocalMapTest, StaleHandlesDoNotVote) {
  std::vector<MapPointId> matched = shared[0];
  for (const MapPointId id : matched) map.erase_point(id);
  local.update(map, matched, frames[3], 80);
  EXPECT_EQ(local.reference.id, frames[3]);
}

TEST_F(LocalMapTest, CopiesAreThoseOfTheMapAndStayWhenItMoves) {
  local.update(map, shared[1], {}, 80);
  const Eigen::Vector3d before = map.at(local.points.id[7]).position_w;
  for (size_t i = 0; i < static_cast<size_t>(local.size()); ++i) {
    const MapPoint& point = map.at(local.points.id[i]);
    EXPECT_EQ(Eigen::Vector3d(local.points.px[i], local.points.py[i], local.points.pz[i]), point.position_w);
    EXPECT_EQ(local.points.d_min[i], point.d_min);
    EXPECT_EQ(local.points.d_max[i], point.d_max);
    EXPECT_EQ(local.points.nz[i], static_cast<float>(point.normal_w.z()));
    EXPECT_EQ(local.points.descriptor[i], point.descriptor);
    EXPECT_FLOAT_EQ(local.match_ratio[i],
                    std::min((static_cast<float>(point.found) + 2.4f) / (static_cast<float>(point.visible) + 4), 1.0f));
  }
  ASSERT_TRUE(map.set_position(local.points.id[7], {9, 9, 9}));
  EXPECT_EQ(Eigen::Vector3d(local.points.px[7], local.points.py[7], local.points.pz[7]), before);
  local.clear();
  EXPECT_EQ(local.size(), 0);
}

}  // namespace
}  // namespace covis
