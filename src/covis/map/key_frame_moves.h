// SPDX-License-Identifier: Apache-2.0
// How the adjustment of a submap with its camera moved the key frames. A pose that was given relative to one of them
// before was measured with another camera: lengths around it were others, and the way to the next key frame as well.
#pragma once

#include <cstdint>
#include <vector>

#include "covis/map/map.h"

namespace covis {

struct KeyFrameMove {
  KeyFrameId key_frame;
  int64_t frame = 0;                         // KeyFrame::frame
  SE3 before, after;                         // T_cw
  double scale_before = 1, scale_after = 1;  // KeyFrame::scale
};

struct KeyFrameMoves {
  std::vector<KeyFrameMove> of;  // in any order; empty: what is relative to key frames need not follow
  uint64_t moves = 0;            // Map::moves() from then on
};

}  // namespace covis
