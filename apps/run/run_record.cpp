// SPDX-License-Identifier: Apache-2.0
#include "apps/run/run_record.h"

#include <algorithm>
#include <utility>

namespace covis::app {
namespace {

FrameState lost_state(RunMode mode) {
  return mode == RunMode::localization ? FrameState::not_localised : FrameState::lost;
}

FrameState state_of(TrackingState state, RunMode mode) {
  switch (state) {
    case TrackingState::tracking:
      return FrameState::tracking;
    case TrackingState::lost:
      return lost_state(mode);
    case TrackingState::not_initialised:
      break;
  }
  return FrameState::not_initialised;
}

}  // namespace

std::string_view name(FrameState state) {
  switch (state) {
    case FrameState::tracking:
      return "tracking";
    case FrameState::lost:
      return "lost";
    case FrameState::not_initialised:
      return "not_initialised";
    case FrameState::not_localised:
      return "not_localised";
    case FrameState::late:
      return "late";
    case FrameState::unreadable:
      return "unreadable";
    case FrameState::camera_gone:
      return "camera_gone";
  }
  return "";
}

FrameStats tracked_frame(const io::Frame& frame, const FrameReport& report, RunMode mode) {
  FrameStats stats;
  stats.frame = frame.index;
  stats.stamp = frame.stamp;
  stats.state = state_of(report.track.state, mode);
  stats.reason = describe(report.track.reason);
  stats.track = report.track;
  stats.timing = report.timing;
  return stats;
}

FrameStats skipped_frame(int64_t frame, Timestamp stamp, FrameState state, std::string reason) {
  FrameStats stats;
  stats.frame = frame;
  stats.stamp = stamp;
  stats.state = state;
  stats.reason = std::move(reason);
  return stats;
}

void settle_states(const Snapshot& snapshot, RunMode mode, SpilledArray<FrameStats>& frames) {
  // All of these come in the order of their frames.
  const auto has = [](const std::vector<PoseOfFrame>& poses, auto& pose, int64_t frame) {
    while (pose != poses.end() && pose->frame < frame) ++pose;
    return pose != poses.end() && pose->frame == frame;
  };
  auto now = snapshot.trajectory.begin(), then = snapshot.online.begin();
  for (FrameStats& frame : frames.all()) {
    const bool has_pose = has(snapshot.trajectory, now, frame.frame);
    const bool had_pose = has(snapshot.online, then, frame.frame);
    if (has_pose && !had_pose) {
      // The first view of a monocular submap gets its pose when the submap begins with the second.
      const bool first_view = std::any_of(snapshot.key_frames.begin(), snapshot.key_frames.end(), [&](const auto& k) {
        return k.frame == frame.frame && k.stamp == frame.stamp;
      });
      frame.state = FrameState::tracking;
      frame.track.method = first_view ? TrackMethod::initialised : TrackMethod::backtracked;
      frame.track.tentative = false;
      frame.reason.clear();
    } else if (!has_pose && frame.state == FrameState::tracking) {
      frame.state = lost_state(mode);
      frame.reason = "its pose was taken back: the place or the map proved wrong";
    }
  }
}

}  // namespace covis::app
