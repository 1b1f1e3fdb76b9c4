// SPDX-License-Identifier: Apache-2.0
#include "covis/tracking/tracked_frame.h"

#include <gtest/gtest.h>

#include "covis/features/test_features.h"

namespace covis {
namespace {

class TrackedFrameTest : public testing::Test {
 protected:
  TrackedFrameTest() { frame.start(random_features(random, 10, 2), 4, 400); }

  Random random{1};
  TrackedFrame frame;
};

TEST_F(TrackedFrameTest, BeginsWithoutMatches) {
  EXPECT_EQ(frame.index, 4);
  EXPECT_EQ(frame.stamp, 400);
  EXPECT_EQ(frame.matches(), 0);
  EXPECT_EQ(frame.mean_depth(), 0);
  frame.set_match(3, {2, 0}, {0, 0, 5}, PointSource::map);
  frame.start(random_features(random, 20, 2), 5, 500);
  EXPECT_EQ(frame.matches(), 0) << "those of the frame before are gone";
  EXPECT_EQ(frame.source.size(), 20u);
  EXPECT_FALSE(frame.points[3].valid());
}

TEST_F(TrackedFrameTest, MatchesComeFromTheMapOrFromDepth) {
  frame.set_match(1, {2, 0}, {0, 0, 5}, PointSource::map);
  frame.set_match(2, {}, {0, 0, 9}, PointSource::depth);
  EXPECT_EQ(frame.matches(), 2);
  EXPECT_TRUE(frame.on_map(1));
  EXPECT_FALSE(frame.on_map(2));
  frame.drop_match(1);
  EXPECT_EQ(frame.matches(), 1);
  EXPECT_FALSE(frame.points[1].valid());
  frame.clear_matches();
  EXPECT_EQ(frame.matches(), 0);
}

TEST_F(TrackedFrameTest, RemembersWhatItsPoseRefused) {
  frame.set_match(0, {5, 1}, {0, 0, 2}, PointSource::map);
  frame.set_match(1, {}, {0, 0, 2}, PointSource::depth);
  frame.refuse_match(0);
  frame.refuse_match(1);
  EXPECT_EQ(frame.matches(), 0);
  ASSERT_EQ(frame.refused.size(), 1u) << "a depth is no point of the map";
  EXPECT_EQ(frame.refused[0].feature, 0u);
  EXPECT_EQ(frame.refused[0].point, (MapPointId{5, 1}));
  for (size_t k = 0; k < 2 * frame.source.size(); ++k) {
    frame.set_match(0, {6, 1}, {0, 0, 2}, PointSource::map);
    frame.refuse_match(0);
  }
  EXPECT_EQ(frame.refused.size(), frame.source.size()) << "no more than it has features";
  frame.clear_matches();
  EXPECT_TRUE(frame.refused.empty());
}

TEST_F(TrackedFrameTest, TheMeanDepthIsThatOfItsMapPointsInTheCamera) {
  frame.T_cw = SE3(Eigen::Matrix3d::Identity(), Eigen::Vector3d(0, 0, 1));  // a metre back
  frame.set_match(1, {2, 0}, {3, 0, 4}, PointSource::map);
  frame.set_match(5, {3, 0}, {0, 1, 6}, PointSource::map);
  frame.set_match(2, {}, {0, 0, 90}, PointSource::depth);
  EXPECT_DOUBLE_EQ(frame.mean_depth(), 6);
}

TEST_F(TrackedFrameTest, ItsMapPointsComeByFeature) {
  frame.set_match(4, {2, 0}, {0, 0, 5}, PointSource::map);
  frame.set_match(1, {3, 1}, {0, 0, 5}, PointSource::map);
  frame.set_match(2, {7, 0}, {0, 0, 9}, PointSource::depth);
  std::vector<MapPointId> matched{{9, 0}};
  frame.map_points(matched);
  EXPECT_EQ(matched, (std::vector<MapPointId>{{3, 1}, {2, 0}}));
}

TEST_F(TrackedFrameTest, MatchedPointsAreThoseOfTheFrameMarkedLast) {
  MatchedPoints matched;
  const MapPointId far_slot{100000, 0};
  EXPECT_FALSE(matched.contains({2, 0}));
  frame.set_match(1, {2, 0}, {0, 0, 5}, PointSource::map);
  frame.set_match(4, far_slot, {0, 0, 5}, PointSource::map);
  frame.set_match(2, {7, 0}, {0, 0, 9}, PointSource::depth);
  matched.mark(frame);
  EXPECT_TRUE(matched.contains({2, 0}));
  EXPECT_TRUE(matched.contains(far_slot));
  EXPECT_FALSE(matched.contains({3, 0}));
  EXPECT_FALSE(matched.contains({7, 0})) << "its own depth is no point of the map";
  frame.drop_match(1);
  matched.mark(frame);
  EXPECT_FALSE(matched.contains({2, 0}));
  EXPECT_TRUE(matched.contains(far_slot));
}

TEST_F(TrackedFrameTest, ItsRequestHasTheImageAndNoMatches) {
  frame.set_match(3, {2, 0}, {0, 0, 5}, PointSource::map);
  const KeyFrameRequest request = frame.request();
  EXPECT_EQ(request.frame, 4);
  EXPECT_EQ(request.stamp, 400);
  EXPECT_EQ(request.features, frame.features);
  EXPECT_EQ(request.points, std::vector<MapPointId>(10)) << "whoever asks knows which matches to hand on";
}

}  // namespace
}  // namespace covis
