// SPDX-License-Identifier: Apache-2.0
#include "covis/tracking/point_counts.h"

#include <gmock/gmock.h>

#include "covis/features/test_features.h"

namespace covis {

// By argument-dependent lookup for the matchers below.
inline bool operator==(const PointCount& a, const PointCount& b) {
  return a.point == b.point && a.visible == b.visible && a.found == b.found;
}

namespace {

using testing::ElementsAre;
using testing::IsEmpty;

class PointCountsTest : public testing::Test {
 protected:
  // One frame that has these points in view and matched those.
  void count(const std::vector<MapPointId>& in_view, const std::vector<MapPointId>& matched) {
    Random random(1);
    TrackedFrame frame;
    frame.start(random_features(random, 10, 2), 0, 0);
    for (size_t k = 0; k < matched.size(); ++k) frame.set_match(k + 2, matched[k], {0, 0, 5}, PointSource::map);
    frame.set_match(9, {50, 0}, {0, 0, 5}, PointSource::depth);
    std::vector<MapPointId> points = in_view;
    std::vector<uint8_t> seen(points.size(), 1);
    points.push_back({60, 0});  // one of the local map that is out of view
    seen.push_back(0);
    counts.add(points, seen, frame);
  }

  const MapPointId a{5, 0}, b{2, 0}, c{100000, 0};
  PointCounts counts;
};

TEST_F(PointCountsTest, FramesInViewAndFramesMatched) {
  count({a, b}, {a});
  count({b, a}, {a, b});
  count({a}, {});
  EXPECT_THAT(counts.take(), ElementsAre(PointCount{a, 3, 2}, PointCount{b, 2, 1}))
      << "in the order of the first count";
}

TEST_F(PointCountsTest, TakingStartsAnew) {
  count({a, c}, {c});
  EXPECT_THAT(counts.take(), ElementsAre(PointCount{a, 1, 0}, PointCount{c, 1, 1}));
  EXPECT_THAT(counts.take(), IsEmpty());
  count({c}, {});
  EXPECT_THAT(counts.take(), ElementsAre(PointCount{c, 1, 0}));
  count({a}, {a});
  counts.clear();
  EXPECT_THAT(counts.take(), IsEmpty());
}

TEST_F(PointCountsTest, ASlotUsedAgainCountsItsPointsApart) {
  const MapPointId next{a.slot, a.generation + 1};
  count({a, b}, {a});
  count({next}, {next});
  count({next}, {});
  EXPECT_THAT(counts.take(), ElementsAre(PointCount{a, 1, 1}, PointCount{b, 1, 0}, PointCount{next, 2, 1}));
}

TEST_F(PointCountsTest, APointOutOfViewMayBeMatched) {
  count({}, {a});
  EXPECT_THAT(counts.take(), ElementsAre(PointCount{a, 0, 1}));
}

}  // namespace
}  // namespace covis
