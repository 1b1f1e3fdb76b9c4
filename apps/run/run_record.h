// SPDX-License-Identifier: Apache-2.0
// The record of one `covis run`, filled during the run: one row per frame. Older rows are in a temporary file.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "apps/view/rows.h"
#include "covis/core/sensor.h"
#include "covis/core/spilled_array.h"
#include "covis/core/time.h"
#include "covis/io/sequence.h"
#include "covis/optimization/lens_adjustment.h"
#include "covis/slam/system.h"

namespace covis::app {

// Result for one frame of the recording. not_localised: a lost frame of a run that localises only; late: dropped in
// real time; unreadable: its image could not be decoded; camera_gone: no frame, but a live camera that went away there.
enum class FrameState { tracking, lost, not_initialised, not_localised, late, unreadable, camera_gone };
std::string_view name(FrameState state);

// Purpose of the run: frames without a pose are lost from a map, or not localised in one.
enum class RunMode { mapping, localization };

struct FrameStats {
  int64_t frame = 0;
  Timestamp stamp = 0;
  FrameState state = FrameState::not_initialised;
  std::string reason;  // reason for the missing pose; empty when tracking
  TrackFigures track;
  double decode_ms = 0;  // time spent waiting for the decoded image
  FrameTiming timing;
  // Processor time of the tracking thread, with what the viewer takes of it; other programs hardly change it.
  double cpu_ms = 0;
  double rss_mb = 0;  // resident memory after this frame, for every hundredth frame; 0: not measured

  // True when the tracker received the frame; only then the fields after `reason` are set.
  bool processed() const {
    return state != FrameState::late && state != FrameState::unreadable && state != FrameState::camera_gone;
  }
  // Cost of tracking a decoded image: the total without waiting for mapping.
  double tracking_ms() const { return timing.total_ms - timing.wait_ms; }
};

// The stages of a frame's processing time, milliseconds.
struct Stage {
  const char* name;
  double (*ms)(const FrameStats&);
};
inline constexpr std::array<Stage, 9> kStages{
    {{"extract", [](const FrameStats& f) { return f.timing.extract_ms; }},
     {"depth", [](const FrameStats& f) { return f.timing.depth_ms; }},
     {"motion", [](const FrameStats& f) { return f.track.ms.motion; }},
     {"local_update", [](const FrameStats& f) { return f.track.ms.local_update; }},
     {"local_search", [](const FrameStats& f) { return f.track.ms.local_search; }},
     {"pose", [](const FrameStats& f) { return f.track.ms.pose; }},
     {"align", [](const FrameStats& f) { return f.track.ms.align; }},
     {"mapping_wait", [](const FrameStats& f) { return f.timing.wait_ms; }},
     {"decode_wait", [](const FrameStats& f) { return f.decode_ms; }}}};

// A camera that was found from the recording (covis/slam/camera_search.h).
struct CameraEstimate {
  std::filesystem::path file;  // the camera file that holds it
  double k1 = 0, k2 = 0;       // its radial coefficients
  Lens sigma;                  // standard deviations
};

struct RunRecord {
  std::string source;  // description of the recording
  Sensor sensor = Sensor::monocular;
  Pinhole given;                           // the recording's camera, as it was before any refinement
  std::optional<CameraEstimate> estimate;  // tells how `given` was found; nullopt: the recording has it
  int image_width = 0, image_height = 0;   // pixels
  SpilledArray<FrameStats> frames;
  std::vector<MappingReport> mapping;
  std::vector<view::LoopPaths> loops;
  std::vector<std::string> notes;  // frames of the recording that were passed over, and why
  int64_t dropped = 0;  // frames of a live camera that were replaced by newer ones before they could be tracked
  std::string failure;  // the reason for an end before that of the recording; empty: there was none
  std::vector<SensorWarning> warnings;
  bool interrupted = false;
  double wall_seconds = 0;
  double first_pose_ms = -1;  // from the first decoded image to the first pose; negative: no pose
};

// Makes the row of a frame that the tracker received.
FrameStats tracked_frame(const io::Frame& frame, const FrameReport& report, RunMode mode);
// Makes the row of a frame that it did not receive: late or unreadable, or of the camera's going.
FrameStats skipped_frame(int64_t frame, Timestamp stamp, FrameState state, std::string reason);
// At the end of a run: frames whose poses were retracted after they were tracked lose their state `tracking`, and those
// that got their pose afterwards have it.
void settle_states(const Snapshot& snapshot, RunMode mode, SpilledArray<FrameStats>& frames);

}  // namespace covis::app
