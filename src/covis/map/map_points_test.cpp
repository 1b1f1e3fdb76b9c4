// SPDX-License-Identifier: Apache-2.0
// Points: replacement, and what is derived from the observers.
#include <gtest/gtest.h>

#include "covis/map/map.h"
#include "covis/map/test_map.h"

namespace covis {
namespace {

// A saved map with more would not be loaded.
TEST(Map, FramesAreCountedUpToWhatAMapFileMayHave) {
  MapFixture f;
  const KeyFrameId a = f.frame(0), b = f.frame(1);
  f.map.attach_to_tree(b);
  const MapPointId p = f.map.add_point({0, 0, 5}, a, 0), q = f.map.add_point({0, 0, 5}, b, 1);
  for (const MapPointId id : {p, q}) {
    f.map.count_visible(id, MapPoint::kMostFrames - 1);
    f.map.count_found(id, 7);
  }
  f.map.replace_point(p, q);
  f.map.count_visible(q, 5);
  EXPECT_EQ(f.map.at(q).visible, MapPoint::kMostFrames);
  EXPECT_EQ(f.map.at(q).found, 16u);
}

TEST(Map, ReplacementForwards) {
  MapFixture f;
  const KeyFrameId a = f.frame(0), b = f.frame(1), c = f.frame(2);
  f.map.attach_to_tree(b);
  f.map.attach_to_tree(c);
  const MapPointId p = f.map.add_point({0, 0, 5}, a, 0), q = f.map.add_point({0, 0, 5}, b, 1),
                   r = f.map.add_point({0, 0, 5}, c, 2);
  f.map.add_observation(p, b, 0);
  f.map.add_observation(q, c, 1);
  f.map.count_found(p, 9);
  EXPECT_TRUE(f.map.replace_point(p, q));  // b sees both: its feature 0 is let go
  EXPECT_FALSE(f.map.at(b).points[0].valid());
  EXPECT_EQ(f.map.at(a).points[0], q);
  EXPECT_EQ(f.map.at(q).found, 11u);
  EXPECT_EQ(f.map.at(q).observations.size(), 3u);
  f.map.add_observation(r, a, 5);
  EXPECT_TRUE(f.map.replace_point(q, r));
  EXPECT_EQ(f.map.forwarded(p), r);
  EXPECT_EQ(f.map.find(p), nullptr);
  EXPECT_FALSE(f.map.replace_point(r, r));
  f.map.erase_point(r);
  EXPECT_FALSE(f.map.forwarded(p).valid());
  EXPECT_EQ(f.map.check(), "");
}

TEST(Map, RefreshingAPoint) {
  MapFixture f;
  const KeyFrameId a = f.frame(-1), b = f.frame(1), c = f.frame(0);
  const MapPointId p = f.map.add_point({0, 0, 4}, a, 3);
  f.map.add_observation(p, b, 4);
  f.map.add_observation(p, c, 5);
  f.map.refresh_point(p);
  const MapPoint& point = f.map.at(p);
  EXPECT_NEAR(point.normal_w.x(), 0, 1e-12);
  EXPECT_GT(point.normal_w.z(), 0.9);
  const Features& features = *f.map.at(a).features;
  EXPECT_NEAR(point.d_max, std::sqrt(17.0) * features.pyramid->scale[features.level[3]], 1e-4);
  EXPECT_NEAR(point.d_min, point.d_max / features.pyramid->scale[7], 1e-4);
  // The one of three descriptors with the least median distance (to itself 0, so the lesser of the two others).
  const std::vector<Descriptor> d{features.descriptor[3], f.map.at(b).features->descriptor[4],
                                  f.map.at(c).features->descriptor[5]};
  int best = 257;
  Descriptor expected;
  for (size_t i = 0; i < 3; ++i) {
    const int median = std::min(hamming(d[i], d[(i + 1) % 3]), hamming(d[i], d[(i + 2) % 3]));
    if (median < best) {
      best = median;
      expected = d[i];
    }
  }
  EXPECT_EQ(point.descriptor, expected);
}

TEST(Map, OneViewWithDepthKeepsAPoint) {
  MapFixture f;
  const KeyFrameId a = f.frame(0, true), b = f.frame(1, false);
  f.map.attach_to_tree(b);
  const MapPointId p = f.map.add_point({0, 0, 2}, a, 0), q = f.map.add_point({0, 0, 2}, a, 1);
  f.map.add_observation(p, b, 0);
  f.map.add_observation(q, b, 1);
  EXPECT_TRUE(f.map.erase_observation(p, b));
  EXPECT_NE(f.map.find(p), nullptr);
  EXPECT_TRUE(f.map.erase_observation(q, a));
  EXPECT_EQ(f.map.find(q), nullptr);
  EXPECT_EQ(f.map.check(), "");
}

// Forgotten in the order of their making, so that no chain is cut in its middle.
TEST(Map, OldReplacementsAreForgotten) {
  MapFixture f;
  const KeyFrameId a = f.frame(0);
  std::vector<MapPointId> points;
  for (uint32_t k = 0; k < 4; ++k) points.push_back(f.map.add_point({0, 0, 5}, a, k));
  for (uint32_t k = 0; k < 3; ++k) {
    EXPECT_TRUE(f.map.replace_point(points[k], points[k + 1]));  // while key frame k is the newest
    f.map.attach_to_tree(f.frame(1 + k));
  }
  EXPECT_EQ(f.map.forwarding_count(), 3u);
  f.map.forget_forwarding(1);
  EXPECT_EQ(f.map.forwarding_count(), 2u);
  EXPECT_FALSE(f.map.forwarded(points[0]).valid());
  EXPECT_EQ(f.map.forwarded(points[1]), points[3]);
  EXPECT_EQ(f.map.forwarded(points[2]), points[3]);
  f.map.forget_forwarding(3);
  EXPECT_EQ(f.map.forwarding_count(), 0u);
  EXPECT_EQ(f.map.forwarded(points[3]), points[3]) << "it lives";
}

}  // namespace
}  // namespace covis
