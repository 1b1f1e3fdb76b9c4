// SPDX-License-Identifier: Apache-2.0
// Maps that stand beside each other in one, until they are joined.
#include <gtest/gtest.h>

#include <cmath>

#include "covis/map/test_map.h"

namespace covis {
namespace {

TEST(Map, PartsStandBesideEachOther) {
  MapFixture f;
  const KeyFrameId a = f.frame(0, true), b = f.frame(1, true);
  f.link(a, b, 30, 0);
  const KeyFrameId c = f.map.begin_submap(20, 0, pose_at(0), f.features(400, true));
  const KeyFrameId d = f.map.add_key_frame(30, 0, pose_at(1), f.features(400, true), f.map.at(c).submap);
  f.map.attach_to_tree(d);  // it shares nothing: below the newest of its own submap
  const MapPointId p = f.map.add_point({0, 0, 5}, a, 300), q = f.map.add_point({0, 0, 5}, c, 300);
  EXPECT_EQ(f.map.at(d).parent, c);
  EXPECT_TRUE(f.map.is_root(a) && f.map.is_root(c));
  EXPECT_EQ(f.map.root(), a);
  EXPECT_EQ(f.map.submaps().size(), 2u);
  EXPECT_EQ(f.map.key_frames(f.map.at(c).submap), (std::vector<KeyFrameId>{c, d}));
  EXPECT_EQ(f.map.check(), "");
  // No point is seen from both, no root is erased.
  EXPECT_FALSE(f.map.add_observation(p, c, 5));
  EXPECT_FALSE(f.map.replace_point(p, q));
  EXPECT_FALSE(f.map.erase_key_frame(c));
  EXPECT_EQ(f.map.check(), "");
  EXPECT_TRUE(f.map.erase_submap(f.map.at(c).submap));
  EXPECT_FALSE(f.map.erase_submap(1));
  EXPECT_EQ(f.map.find(q), nullptr);
  EXPECT_EQ(f.map.key_frame_count(), 2u);
  EXPECT_EQ(f.map.check(), "");
  const KeyFrameId e = f.map.begin_submap(40, 0, SE3(), f.features(10, true));
  EXPECT_EQ(f.map.at(e).submap, 2u) << "numbers are not used again";
}

// The look of a submap from within does not change when it is joined to another.
TEST(Map, JoiningMovesAPartAsAWhole) {
  MapFixture f;
  const KeyFrameId a = f.frame(0, true), b = f.frame(1, true);
  f.map.attach_to_tree(b);
  const uint32_t submap = f.map.at(f.map.begin_submap(20, 0, pose_at(0), f.features(400, true))).submap;
  const auto add = [&](double x) {
    return f.map.add_key_frame(static_cast<int64_t>(x), 0, pose_at(x), f.features(400, true), submap);
  };
  const KeyFrameId root = f.map.key_frames(submap).front(), c = add(1), d = add(2), gone = add(3);
  f.link(root, c, 40, 0);
  f.link(c, d, 40, 50);
  f.link(d, gone, 40, 100);
  const MapPointId p = f.map.add_point({0.3, -0.2, 5}, d, 200);
  f.map.add_observation(p, root, 200);
  f.map.refresh_point(p);
  f.map.add_loop_edge(root, d);
  EXPECT_TRUE(f.map.erase_key_frame(gone));
  const Eigen::Vector3d seen = f.map.at(d).T_cw * f.map.at(p).position_w;
  const float d_max = f.map.at(p).d_max;
  const SE3 T_gone_d = f.map.resolve(gone)->T_ar;
  const uint64_t moves = f.map.moves();

  const Sim3 S(so3_exp({0.1, 0.7, -0.3}), {4, 5, 6}, 2.5);
  EXPECT_FALSE(f.map.join_submaps(c, d, S)) << "of one submap";
  EXPECT_FALSE(f.map.join_submaps(d, b, Sim3(Eigen::Matrix3d::Identity(), {0, NAN, 0}, 1)));
  EXPECT_EQ(f.map.moves(), moves);
  EXPECT_TRUE(f.map.join_submaps(d, b, S));
  EXPECT_GT(f.map.moves(), moves);
  EXPECT_EQ(f.map.check(), "");
  EXPECT_EQ(f.map.submaps().size(), 1u);
  EXPECT_EQ(f.map.root(), a);
  for (const KeyFrameId& id : {root, c, d}) EXPECT_EQ(f.map.at(id).submap, f.map.at(a).submap);
  EXPECT_EQ(f.map.at(d).parent, b);
  EXPECT_EQ(f.map.at(c).parent, d) << "the key frame that was tied is the root of its tree";
  EXPECT_EQ(f.map.at(root).parent, c);
  const Eigen::Vector3d now = f.map.at(d).T_cw * f.map.at(p).position_w;
  EXPECT_LT((now - 2.5 * seen).norm(), 1e-9);
  EXPECT_NEAR(f.map.at(p).d_max, 2.5 * d_max, 1e-4);
  const MapPoint moved = f.map.at(p);
  f.map.refresh_point_geometry(p);
  EXPECT_LT((moved.normal_w - f.map.at(p).normal_w).norm(), 1e-9);
  EXPECT_NEAR(moved.d_min, f.map.at(p).d_min, 1e-4);
  // Poses given before, of erased key frames as well, come along in the new unit.
  const auto resolved = f.map.resolve(gone);
  ASSERT_TRUE(resolved);
  EXPECT_DOUBLE_EQ(resolved->scale, 2.5);
  EXPECT_LT((resolved->T_ar.t() - 2.5 * T_gone_d.t()).norm(), 1e-9);
}

}  // namespace
}  // namespace covis
