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

// A map that is to be merged.
struct MergeSource {
  MapState map;
  Sensor sensor = Sensor::monocular;
  Camera given = {};  // the camera as it was given; the map may have refined it
};

// One of the maps that were merged.
struct MergedInput {
  std::vector<uint32_t> submaps;  // its submaps by the ids of JoinReport, before any was joined
  uint32_t first_serial = 0;      // offset that was added to the serials of its key frames
  size_t key_frames = 0, points = 0;
};

struct MergeReport {
  std::vector<MergedInput> inputs;  // as they were given
  size_t camera_of = 0;             // the input whose camera, as it is there, the merged map has
  JoinReport join;
};

// The merged map has the camera of a map with depth, if there is one: a stereo camera rather than one with a depth
// sensor, whose noise that of stereo is not; and of several the map of the most key frames, which knows the refinement
// best. Maps of other cameras are expressed in it (map/camera_change.h), those of the same one are adjusted to it.
// `merged` must be empty. Fails when the maps together are more than one map can be, or are not sound.
Result<MergeReport> merge_maps(std::vector<MergeSource> maps, const Vocabulary& vocabulary, const LoopOptions& options,
                               SharedMap& merged);

}  // namespace covis
