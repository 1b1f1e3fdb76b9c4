// SPDX-License-Identifier: Apache-2.0
// Makes one map of the submaps that show the same places, after all of them were mapped: each pair that join_plan.h
// believes is joined as while running, then every claim ties both in one pose graph, the points of both are fused, and
// the joined submap is adjusted as a whole. Submaps that share nothing stay as they are, in worlds of their own.
// The oldest submap of those joined keeps its world; of cameras with and without depth the oldest one with depth, so
// that what is joined has metres for its unit as soon as one part has. Sources: Elvira, Tardós, Montiel,
// "ORBSLAM-Atlas", IROS 2019; Campos et al., "ORB-SLAM3", T-RO 2021, section VI.
#pragma once

#include <cstdint>
#include <optional>

#include "covis/core/sensor.h"
#include "covis/loops/join_report.h"
#include "covis/loops/loop_options.h"
#include "covis/map/shared_map.h"
#include "covis/mapping/mapper_options.h"

namespace covis {

struct JoinSettings {
  Sensor sensor = Sensor::monocular;
  LoopOptions loop;
  MapperOptions mapper;  // for fusing neighbours
  int seed = 0;          // seed of the random choices
};

// Key frames must have words.
JoinReport join_submaps(SharedMap& map, const JoinSettings& settings);

// Adjusts all of a submap, its root fixed. Nothing when there was nothing to adjust or the adjustment failed.
std::optional<AdjustedCost> adjust_submap(SharedMap& map, uint32_t submap, int iterations);

}  // namespace covis
