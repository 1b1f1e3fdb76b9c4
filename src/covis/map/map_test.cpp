// SPDX-License-Identifier: Apache-2.0
#include "covis/map/map.h"

#include <gtest/gtest.h>

#include "covis/map/test_map.h"

namespace covis {
namespace {

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
  std::weak_ptr<const Features> features = f.map.at(e).features;
  EXPECT_TRUE(f.map.erase_key_frame(e));
  EXPECT_FALSE(f.map.erase_key_frame(e));
  EXPECT_TRUE(features.expired());  // memory is really released
  EXPECT_EQ(f.map.check(), "");
  EXPECT_EQ(f.map.at(x).parent, root);
  EXPECT_EQ(f.map.at(y).parent, x);
  EXPECT_EQ(f.map.at(z).parent, root);
  // Poses of the erased are still known, and follow their ancestors.
  EXPECT_TRUE(f.map.erase_key_frame(x));
  const auto resolved = f.map.resolve(x);
  ASSERT_TRUE(resolved);
  EXPECT_EQ(resolved->key_frame, root);
  EXPECT_LT((resolved->T_ar.t() - T_xr.t()).norm(), 1e-12);
  EXPECT_LT((f.map.resolve(e)->T_ar.t() - T_er.t()).norm(), 1e-12);
  EXPECT_FALSE(f.map.resolve(KeyFrameId{77, 0}));
  EXPECT_EQ(f.map.check(), "");
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

}  // namespace
}  // namespace covis
