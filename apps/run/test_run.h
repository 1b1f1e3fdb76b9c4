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

inline RunResults made_results() {
  RunResults results;
  results.camera = {500, 501, 320, 240, 40};
  results.submaps = {{.id = 0, .loaded = false, .frames = 4, .key_frames = 2, .points = 30},
                     {.id = 3, .loaded = true, .frames = 2, .key_frames = 1, .points = 12}};
  for (int64_t k = 0; k < 10; ++k) {
    if (k == 7) continue;  // late
    FrameRecord& record = results.records.emplace_back();
    record.frame = k;
    record.tracked = k >= 1 && k != 5 && k != 6;
    record.online = record.tracked && k != 1;
    if (!record.tracked) continue;
    const double s = static_cast<double>(k);
    const SE3 T_wc(Eigen::Matrix3d::Identity(), {s, s * s / 10, 0});
    const int submap = k < 5 ? 0 : 1;
    results.poses.push_back({k, from_seconds(s), T_wc, submap, submap == 0 ? 0u : 3u});
    if (submap == 0) results.trajectory.push_back({from_seconds(s), T_wc});
  }
  results.online_trajectory = results.trajectory;
  results.key_frames = {results.trajectory.front()};
  results.points = {{1, 2, 3}};
  return results;
}

}  // namespace covis::app
