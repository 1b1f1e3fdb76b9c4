// SPDX-License-Identifier: Apache-2.0
// For the tests of the map: one to put key frames into, which share points by the dozen.
#pragma once

#include <gtest/gtest.h>

#include "covis/core/random.h"
#include "covis/features/test_features.h"
#include "covis/map/map.h"

namespace covis {

// A camera at (x, 0, 0) that looks along z.
inline SE3 pose_at(double x) { return SE3(Eigen::Matrix3d::Identity(), Eigen::Vector3d(-x, 0, 0)); }

struct MapFixture {
  Random random{1};
  Map map;

  FeaturesPtr features(int count, bool with_depth) { return random_features(random, count, with_depth ? 2 : 0); }
  KeyFrameId frame(double x, bool with_depth = false) {
    return map.add_key_frame(static_cast<int64_t>(10 * x), 0, pose_at(x), features(400, with_depth));
  }
  // `count` new points seen by both, from feature `first` on.
  void share(KeyFrameId a, KeyFrameId b, int count, uint32_t first) {
    for (uint32_t k = 0; k < static_cast<uint32_t>(count); ++k) {
      const MapPointId p = map.add_point({0, 0, 5}, a, first + k);
      ASSERT_TRUE(p.valid());
      ASSERT_TRUE(map.add_observation(p, b, first + k));
    }
  }
  // And b takes its place in the tree.
  void link(KeyFrameId a, KeyFrameId b, int count, uint32_t first) {
    share(a, b, count, first);
    map.attach_to_tree(b);
  }
};

}  // namespace covis
