// SPDX-License-Identifier: Apache-2.0
// One `covis run`: what it counted, and that in JSON.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "covis/core/sensor.h"
#include "covis/core/time.h"
#include "covis/io/sequence.h"
#include "covis/slam/system.h"

namespace covis::app {

// One line of stats.jsonl.
struct FrameStats {
  int64_t frame = 0;
  Timestamp stamp = 0;
  std::string state;  // tracking, lost, not_initialised, not_localised; late (dropped in real time); unreadable
  std::string reason;
  TrackFigures track;
  double decode_ms = 0;  // waiting for the decoded image
  FrameTiming timing;
  double cpu_ms = 0;  // time the tracking thread itself worked: other busy programs do not enter
  double rss_mb = 0;  // resident memory after this frame, of every hundredth; 0: not asked
  // What tracking cost, image already decoded: everything but waiting for mapping.
  double tracking_ms() const { return timing.total_ms - timing.wait_ms; }
};

struct RunRecord {
  std::string source;  // description of the recording
  Sensor sensor = Sensor::monocular;
  std::vector<FrameStats> frames;
  std::vector<MappingReport> mapping;
  int late_frames = 0;
  int unreadable_frames = 0;
  bool interrupted = false;
  double wall_seconds = 0;
  double first_pose_ms = -1;  // from the first decoded image to the first pose; negative: there was none
};

// Of a frame that was tracked, or should have been.
FrameStats to_stats(const io::Frame& frame, const FrameReport& report, bool localize);
// Of one that was not looked at: late or unreadable.
FrameStats untracked(int64_t frame, Timestamp stamp, const char* state, const std::string& reason);
// At the end: frames that were tracked, but whose poses were taken back since.
void mark_taken_back(const Snapshot& snapshot, bool localize, std::vector<FrameStats>& frames);
bool processed(const FrameStats& frame);

// stats.jsonl: a line a frame, with what mapping did of it and the map its pose belongs to.
std::string stats_text(const RunRecord& run, const Snapshot& snapshot);
// summary.json, without the errors against the truth.
nlohmann::json summarise(const RunRecord& run, const Snapshot& snapshot);

}  // namespace covis::app
