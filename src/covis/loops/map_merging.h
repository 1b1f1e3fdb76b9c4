// SPDX-License-Identifier: Apache-2.0
// Many saved maps as one map: their submaps side by side, those that show the same places joined.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "covis/core/error.h"
#include "covis/loops/join_report.h"
#include "covis/loops/submap_joining.h"
#include "covis/map/map_state.h"
#include "covis/map/shared_map.h"
#include "covis/vocabulary/vocabulary.h"

namespace covis {

// One of the maps that were merged.
struct MergedInput {
  std::vector<uint32_t> submaps;  // its submaps by the ids of JoinReport, before any was joined
  size_t key_frames = 0, points = 0;
};

struct MergeReport {
  std::vector<MergedInput> inputs;  // as they were given
  size_t camera_of = 0;             // the input whose camera, as refined there, the merged map has
  JoinReport join;
};

// All maps must be of one camera as it was given (storage/compatibility.h); the map of the most key frames knows its
// refinement best. `merged` must be empty. The first map's oldest submap keeps its world. Fails when the maps together
// are more than one map can be, or are not sound.
Result<MergeReport> merge_maps(std::vector<MapState> maps, const Vocabulary& vocabulary, const JoinSettings& settings,
                               SharedMap& merged);

}  // namespace covis
