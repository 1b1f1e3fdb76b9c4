// SPDX-License-Identifier: Apache-2.0
// The figures of one `covis run`, computed in one place from its record and its results; JSON, text and the report
// only show them.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "apps/run/run_record.h"
#include "covis/eval/evaluation.h"

namespace covis::app {

// The results of a run, as the system gives them at its end.
struct RunResults {
  Pinhole camera;                      // the intrinsics in use, refined ones too
  std::vector<SubmapSummary> submaps;  // maps that are not joined have a world each; the first is the main one
  std::vector<FrameRecord> records;
  std::vector<PoseOfFrame> poses;
  // The main map alone.
  Trajectory trajectory, online_trajectory, key_frames;
  std::vector<Eigen::Vector3d> points;
  uint64_t refused_non_finite = 0;  // commits refused for a value that was not finite
};
RunResults results_of(const System& system);

struct Spread {
  double median = 0, p95 = 0;
};

struct FrameCounts {
  size_t all = 0;
  size_t tracked = 0;         // have a pose at the end
  size_t tracked_online = 0;  // had one at once
  int64_t first_tracked = -1;
  size_t late = 0, unreadable = 0;
};

struct MapCounts {
  size_t key_frames = 0, points = 0;
  size_t key_frames_made = 0;  // with those removed since
  uint64_t refused_non_finite = 0;
  std::vector<SubmapSummary> submaps;
};

// Milliseconds, of the frames that the tracker had.
struct FrameTimes {
  Spread tracking, frame, cpu;
  std::vector<std::pair<const char*, Spread>> stages;   // kStages
  std::vector<std::pair<const char*, Spread>> mapping;  // for each key frame
};

struct RunCosts {
  double wall_seconds = 0, frames_per_second = 0;
  double first_pose_ms = -1;  // negative: there was no pose
  double peak_rss_mb = 0;
};

// A loop that was closed, or two submaps that were joined.
struct LoopSummary {
  int64_t frame = 0;  // the key frame's
  LoopReport report;
  double full_ba_ms = 0;  // the full bundle adjustment that followed
};

// A run of frames without a pose and with the same state.
struct Loss {
  int64_t first = 0, last = 0;
  FrameState state = FrameState::lost;
  std::string reason;  // its first frame's
};

// Errors against the truth, metres.
struct Accuracy {
  struct Scaled {
    double ate = 0;    // after alignment with scale
    double scale = 1;  // the estimate times this fits the truth
  };
  AlignMode alignment = AlignMode::se3;
  double ate = 0, ate_online = 0;  // RMSE, of the final and of the online trajectory
  double path_length = 0;          // length of the true path
  std::optional<Scaled> scaled;
};

struct RunSummary {
  std::string source;
  Sensor sensor = Sensor::monocular;
  Pinhole camera;
  bool interrupted = false;
  FrameCounts frames;
  MapCounts map;
  FrameTimes times;
  RunCosts costs;
  std::vector<LoopSummary> loops, merges;
  std::vector<Loss> not_tracked;
  std::optional<Accuracy> accuracy;  // empty without truth
};

// Alignment that a sensor's trajectory needs: a single camera can't know the scale.
constexpr AlignMode alignment_of(Sensor sensor) {
  return sensor == Sensor::monocular ? AlignMode::sim3 : AlignMode::se3;
}
const char* name_of_alignment(AlignMode mode);  // "se3" or "sim3"

// truth: of the camera; may be null.
RunSummary summarise(const RunRecord& run, const RunResults& results, const Trajectory* truth, double peak_rss_mb);

}  // namespace covis::app
