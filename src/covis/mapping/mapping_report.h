// SPDX-License-Identifier: Apache-2.0
// The mapper's report on a key frame.
#pragma once

#include "covis/map/map_requests.h"

namespace covis {

struct MappingCounts {
  int points_created = 0, points_fused = 0, points_culled = 0, key_frames_culled = 0, key_frames_thinned = 0;
};

// The local bundle adjustment; all 0 when there was none.
struct AdjustmentReport {
  int key_frames = 0;  // that could move
  int points = 0;      // all of them move
  int observations = 0;
  bool interrupted = false;
};

// Milliseconds of each stage.
struct MappingTimes {
  double insert = 0, cull_points = 0, create = 0, fuse = 0, align = 0, adjust = 0, cull_key_frames = 0;
};

struct MapperReport : KeyFrameMade {
  MappingCounts counts;
  AdjustmentReport adjustment;
  MappingTimes ms;
};

}  // namespace covis
