// SPDX-License-Identifier: Apache-2.0
// The requests to the back end besides key frames, and its report on a key frame.
#pragma once

#include <cstdint>
#include <optional>
#include <variant>
#include <vector>

#include "covis/loops/loop_report.h"
#include "covis/map/key_frame_moves.h"
#include "covis/mapping/depth_against_motion.h"
#include "covis/mapping/mapping_report.h"
#include "covis/tracking/backtrack.h"

namespace covis {

// A submap is forgotten (a monocular one that failed in its first moments).
struct DiscardSubmap {
  uint32_t submap = 0;
};
// The first so many erased key frames are forgotten (Map::forget_erased()).
struct ForgetErased {
  uint64_t count = 0;
};
// The result of the job in the background is waited for and applied.
struct FinishAdjustment {};

using BackendRequest = std::variant<KeyFrameRequest, InitialMapRequest, DiscardSubmap, ForgetErased, FinishAdjustment>;

// The answer to a KeyFrameRequest or an InitialMapRequest.
struct MappingReport : MapperReport {
  LoopReport loop;
  Backtracked earlier;            // frames without a pose that came with the request
  KeyFrameMoves moves = {};       // as the job in the background moved key frames
  double loop_ms = 0;             // loop closing, and applying and starting jobs in the background
  double full_adjustment_ms = 0;  // the full bundle adjustment whose result was applied with this key frame
  double total_ms = 0;
  std::vector<DepthAgainstMotion> depth_checks = {};  // none: depth was not compared
};

}  // namespace covis
