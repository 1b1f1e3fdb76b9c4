// SPDX-License-Identifier: Apache-2.0
// All settings of the system, each with its default, unit and meaning. Classes get the slice that they read.
#pragma once

#include "covis/core/fields.h"
#include "covis/core/schedule.h"
#include "covis/core/sensor.h"
#include "covis/features/frontend.h"
#include "covis/loops/loop_options.h"
#include "covis/mapping/mapper_options.h"
#include "covis/tracking/tracking_options.h"

namespace covis {

struct SystemOptions {
  Sensor sensor = Sensor::monocular;
  OrbOptions orb;
  TrackerOptions tracker;
  MapperOptions mapper;
  LoopOptions loop;
  // Frames after a key frame at which what mapping made of it becomes visible to tracking; sooner near a loss.
  int mapping_delay = 2;
  bool realtime = false;  // instead: as soon as it is ready; mapping is interrupted by new key frames
  bool localize = false;  // localisation only: the map is not touched (algorithms.md §3.7)
  // Newest frames whose poses are kept, at least; at most twice as many are. 0: all, some 200 bytes each.
  int trajectory_frames = 0;
  int seed = 0;  // seed of the random choices

  Schedule schedule() const { return realtime ? Schedule::realtime : Schedule::deterministic; }
};
Fields fields(SystemOptions& options);

}  // namespace covis
