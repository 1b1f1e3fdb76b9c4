// SPDX-License-Identifier: Apache-2.0
// Covisibility and the essential graph.
#include <gtest/gtest.h>

#include "covis/map/map.h"
#include "covis/map/test_map.h"

namespace covis {
namespace {

TEST(Map, CovisibilityQueries) {
  MapFixture f;
  const KeyFrameId a = f.frame(0), b = f.frame(1), c = f.frame(2), d = f.frame(3);
  f.share(a, b, 20, 0);
  f.share(a, c, 30, 50);
  f.share(a, d, 5, 100);
  f.share(b, d, 120, 150);
  for (const KeyFrameId id : {b, c, d}) f.map.attach_to_tree(id);
  EXPECT_EQ(f.map.check(), "");
  EXPECT_EQ(f.map.weight(a, b), 20);
  EXPECT_EQ(f.map.weight(c, d), 0);
  auto n = f.map.neighbours(a);
  ASSERT_EQ(n.size(), 2u);  // d shares too few
  EXPECT_EQ(n[0].key_frame, c);
  EXPECT_EQ(n[1].key_frame, b);
  EXPECT_EQ(f.map.best_neighbours(a, 1).size(), 1u);
  EXPECT_EQ(f.map.neighbours_above(a, 25).size(), 1u);
  EXPECT_EQ(f.map.neighbours_above(a, 5).size(), 3u);
  EXPECT_EQ(f.map.tracked_points(a, 2), 55);
  EXPECT_EQ(f.map.tracked_points(a, 3), 0);
  EXPECT_EQ(f.map.at(d).parent, b);
  // The essential graph: three tree edges, of which b-d is heavy too, and a loop edge.
  f.map.add_loop_edge(c, d);
  EXPECT_EQ(f.map.essential_graph().size(), 4u);
  EXPECT_EQ(f.map.check(), "");
}

TEST(Map, TheBestNeighbourStaysThoughItSharesFew) {
  MapFixture f;
  const KeyFrameId a = f.frame(0), b = f.frame(1), c = f.frame(2);
  f.share(a, b, 4, 0);
  f.share(a, c, 6, 20);
  const auto n = f.map.neighbours(a);
  ASSERT_EQ(n.size(), 1u);
  EXPECT_EQ(n[0].key_frame, c);
}

}  // namespace
}  // namespace covis
