// SPDX-License-Identifier: Apache-2.0
// The figures of one `covis run`, computed in one place from its record and the snapshot at its end; JSON, text and the
// report only show them.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "apps/run/run_record.h"
#include "covis/eval/evaluation.h"
#include "covis/io/outputs.h"

namespace covis::app {

// The main submap: what is not joined to it has a world of its own.
struct MainSubmap {
  Trajectory trajectory, online_trajectory, key_frames;
  std::vector<io::CloudPoint> points;
};
MainSubmap main_submap(const Snapshot& snapshot);

struct Spread {
  double median = 0, p95 = 0;
};

struct FrameCounts {
  size_t all = 0;             // without those that a live camera dropped
  size_t tracked = 0;         // number of frames with a pose at the end
  size_t tracked_online = 0;  // number of frames with a pose immediately after tracking
  int64_t first_tracked = -1;
  size_t late = 0, unreadable = 0;
  int64_t dropped = 0;     // by a live camera, for newer ones
  size_t camera_gone = 0;  // number of times that a live camera went away
};

struct MapCounts {
  size_t key_frames = 0, points = 0;
  size_t key_frames_made = 0;     // includes those removed later
  size_t key_frames_thinned = 0;  // removed to keep the map within its bound of memory
  uint64_t refused_non_finite = 0;
  std::vector<SubmapSummary> submaps;
};

// Milliseconds, over the frames that the tracker received.
struct FrameTimes {
  Spread tracking, frame, cpu;
  std::vector<std::pair<const char*, Spread>> stages;   // one per entry of kStages
  std::vector<std::pair<const char*, Spread>> mapping;  // per key frame
};

struct RunCosts {
  double wall_seconds = 0, frames_per_second = 0;
  double first_pose_ms = -1;  // negative: there was no pose
  double peak_rss_mb = 0;
};

// A closed loop, or two submaps that were joined.
struct LoopSummary {
  int64_t frame = 0;  // frame of the key frame
  LoopReport report;
  double full_ba_ms = 0;  // duration of the full bundle adjustment that followed
};

// Consecutive frames without a pose and with the same state.
struct Loss {
  int64_t first = 0, last = 0;
  FrameState state = FrameState::lost;
  std::string reason;  // reason of its first frame
};

// Errors relative to the ground truth, metres.
struct Accuracy {
  struct Scaled {
    double ate = 0;    // error after alignment with scale
    double scale = 1;  // factor that fits the estimate to the ground truth
  };
  AlignMode alignment = AlignMode::se3;
  double ate = 0, ate_online = 0;  // RMSE of the final and of the online trajectory
  double path_length = 0;          // length of the ground truth
  std::optional<Scaled> scaled;
};

struct RunSummary {
  std::string source;
  Sensor sensor = Sensor::monocular;
  Pinhole camera, given;                   // in use at the end, and as the recording has it
  int image_height = 0;                    // pixels
  std::optional<CameraEstimate> estimate;  // tells how `given` was found; nullopt: the recording has it
  bool interrupted = false;
  std::vector<std::string> notes;  // frames of the recording that were passed over, and why
  std::string failure;             // the reason for an end before that of the recording; empty: there was none
  FrameCounts frames;
  MapCounts map;
  FrameTimes times;
  RunCosts costs;
  std::vector<LoopSummary> loops, merges;
  std::vector<Loss> not_tracked;
  std::vector<SensorWarning> warnings;
  std::optional<Accuracy> accuracy;  // only if there is ground truth
};

// Returns the alignment for a sensor's trajectory: a single camera cannot observe the scale.
constexpr AlignMode alignment_of(Sensor sensor) {
  return sensor == Sensor::monocular ? AlignMode::sim3 : AlignMode::se3;
}
// True when the map moved the focal length.
inline bool refined(const RunSummary& s) { return s.camera.fx != s.given.fx; }
inline bool registration_found(const RunSummary& s) {
  return s.camera.registration.any() && s.camera.registration != s.given.registration;
}
inline bool shutter_found(const RunSummary& s) {
  return s.camera.row_time != 0 && s.camera.row_time != s.given.row_time;
}
const char* name_of_alignment(AlignMode mode);  // "se3" or "sim3"

// truth: of the camera; may be null.
RunSummary summarise(const RunRecord& run, const Snapshot& snapshot, const Trajectory* truth, double peak_rss_mb);

}  // namespace covis::app
