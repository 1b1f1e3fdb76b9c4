// SPDX-License-Identifier: Apache-2.0
// For tests: a small snapshot with two key frames, three points, an edge of each kind and four frames.
#pragma once

#include <utility>

#include "covis/slam/snapshot.h"

namespace covis::view {

inline SE3 at(double x) { return SE3(Eigen::Matrix3d::Identity(), {x, 0, 0}); }

inline Snapshot small_snapshot() {
  Snapshot snapshot;
  snapshot.camera = {500, 501, 320, 240, 40};
  for (uint32_t k = 0; k < 2; ++k) {
    Snapshot::KeyFrame& key_frame = snapshot.key_frames.emplace_back();
    key_frame.T_wc = at(k);
    key_frame.frame = 3 * k;
    key_frame.stamp = from_seconds(0.1 * k);
    key_frame.id = {7 - k, 0};
    key_frame.serial = 10 + 5 * k;
    if (k == 1) key_frame.parent = snapshot.key_frames.front().id;
  }
  for (uint32_t k = 0; k < 3; ++k) snapshot.points.push_back({{2 * k, 1}, {1.0 * k, 2, 3}, 0});
  snapshot.edges = {{0, 1, 20, true}};
  snapshot.observations = {{0, 0, 10.25f, 20.5f}, {0, 1, 30, 40}, {1, 1, 50, 60}, {1, 2, 70, 80}};
  for (int64_t k = 0; k < 4; ++k) {
    PoseOfFrame pose;
    pose.T_wc = at(static_cast<double>(k) / 3);
    pose.frame = k;
    snapshot.trajectory.push_back(pose);
  }
  return snapshot;
}

}  // namespace covis::view
