// SPDX-License-Identifier: Apache-2.0
// For tests: a hand-made record and results of a small run.
#pragma once

#include "apps/run/run_summary.h"

namespace covis::app {

// Ten frames, one per second: 0 not initialised, 1 to 4 tracked, 5 and 6 lost, 7 late, 8 and 9 tracked, in a second
// map. Frame k takes 10 k ms, 2 of which it waits.
inline RunRecord made_record() {
  RunRecord run;
  run.source = "ten frames";
  run.sensor = Sensor::rgbd;
  run.given = {500, 501, 320, 240, 40};
  run.wall_seconds = 5;
  run.first_pose_ms = 12;
  for (int64_t k = 0; k < 10; ++k) {
    FrameStats frame = skipped_frame(k, from_seconds(static_cast<double>(k)), FrameState::tracking, "");
    if (k == 0) frame.state = FrameState::not_initialised;
    if (k == 5 || k == 6) frame.state = FrameState::lost;
    if (k == 7) frame.state = FrameState::late;
    if (frame.state != FrameState::tracking) frame.reason = "reason " + std::to_string(k);
    frame.timing.total_ms = 10.0 * static_cast<double>(k);
    frame.timing.wait_ms = 2;
    frame.track.inliers = 100;
    run.frames.push_back(frame);
  }
  return run;
}

// Its end: frames 1 to 4 have poses in submap 0, frames 8 and 9 in submap 3, which was loaded. Frame 1 got its pose
// later.
inline Snapshot made_snapshot() {
  Snapshot snapshot;
  snapshot.camera = {500, 501, 320, 240, 40};
  snapshot.submaps = {{.id = 0, .loaded = false, .frames = 4, .key_frames = 2, .points = 30},
                      {.id = 3, .loaded = true, .frames = 2, .key_frames = 1, .points = 12}};
  for (const int64_t k : {1, 2, 3, 4, 8, 9}) {
    const double s = static_cast<double>(k);
    PoseOfFrame pose;
    pose.frame = k;
    pose.stamp = from_seconds(s);
    pose.T_wc = SE3(Eigen::Matrix3d::Identity(), {s, s * s / 10, 0});
    pose.submap = k < 5 ? 0 : 3;
    snapshot.trajectory.push_back(pose);
    if (k != 1) snapshot.online.push_back(pose);
  }
  Snapshot::KeyFrame key_frame;
  static_cast<PoseOfFrame&>(key_frame) = snapshot.trajectory.front();
  snapshot.key_frames = {key_frame};
  snapshot.points = {{{}, {1, 2, 3}, 0}};
  return snapshot;
}

}  // namespace covis::app
