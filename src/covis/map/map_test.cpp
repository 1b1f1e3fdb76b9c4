// SPDX-License-Identifier: Apache-2.0
#include "covis/map/map.h"

#include <gtest/gtest.h>

#include "covis/map/test_map.h"

namespace covis {
namespace {

TEST(SlotStore, StaleHandlesFindNothing) {
  SlotStore<MapPointId, int> store;
  const MapPointId a = store.insert(1), b = store.insert(2);
  EXPECT_TRUE(store.erase(a));
  EXPECT_FALSE(store.erase(a));
  EXPECT_EQ(store.find(a), nullptr);
  const MapPointId c = store.insert(3);
  EXPECT_EQ(c.slot, a.slot);
  EXPECT_NE(c, a);
  EXPECT_EQ(store.find(a), nullptr);
  EXPECT_EQ(store.at(b), 2);
  EXPECT_EQ(store.size(), 2u);
}

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

TEST(Map, ErasingAKeyFrameReattachesItsChildren) {
  MapFixture f;
  const KeyFrameId root = f.frame(0), e = f.frame(1), x = f.frame(2), y = f.frame(3), z = f.frame(4);
  f.link(root, e, 50, 0);
  f.link(e, x, 60, 60);
  f.link(e, y, 60, 130);
  f.link(e, z, 60, 200);
  f.share(root, x, 20, 300);  // x belongs to the root then, …
  f.share(x, y, 30, 330);     // … y to x, and z, which shares nothing with any, to the erased one's parent
  EXPECT_EQ(f.map.at(z).parent, e);
  const SE3 T_xr = f.map.at(x).T_cw * f.map.at(root).T_cw.inverse(),
            T_er = f.map.at(e).T_cw * f.map.at(root).T_cw.inverse();
  EXPECT_FALSE(f.map.erase_key_frame(root));
  f.map.protect(e);
  EXPECT_FALSE(f.map.erase_key_frame(e));
  f.map.unprotect(e);
  std::weak_ptr<const Features> features = f.map.at(e).features;
  EXPECT_TRUE(f.map.erase_key_frame(e));
  EXPECT_FALSE(f.map.erase_key_frame(e));
  EXPECT_TRUE(features.expired());  // memory is really released
  EXPECT_EQ(f.map.check(), "");
  EXPECT_EQ(f.map.at(x).parent, root);
  EXPECT_EQ(f.map.at(y).parent, x);
  EXPECT_EQ(f.map.at(z).parent, root);
  // Poses of the erased can still be told, and follow their ancestors.
  EXPECT_TRUE(f.map.erase_key_frame(x));
  const auto resolved = f.map.resolve(x);
  ASSERT_TRUE(resolved);
  EXPECT_EQ(resolved->key_frame, root);
  EXPECT_LT((resolved->T_ar.t() - T_xr.t()).norm(), 1e-12);
  EXPECT_LT((f.map.resolve(e)->T_ar.t() - T_er.t()).norm(), 1e-12);
  EXPECT_FALSE(f.map.resolve(KeyFrameId{77, 0}));
  EXPECT_EQ(f.map.check(), "");
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
  // Of three descriptors the one with the least median distance (to itself 0, so the lesser of the two others).
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

TEST(Map, RefusesWhatIsNotFinite) {
  MapFixture f;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const KeyFrameId a = f.frame(0);
  EXPECT_FALSE(f.map.add_key_frame(0, 0, pose_at(nan), f.features(3, false)).valid());
  EXPECT_FALSE(f.map.set_pose(a, pose_at(nan)));
  EXPECT_FALSE(f.map.add_point({nan, 0, 1}, a, 0).valid());
  const MapPointId p = f.map.add_point({0, 0, 1}, a, 0);
  EXPECT_FALSE(f.map.set_position(p, {0, nan, 1}));
  EXPECT_EQ(f.map.refused_non_finite(), 4u);
  EXPECT_EQ(f.map.check(), "");
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

}  // namespace
}  // namespace covis
