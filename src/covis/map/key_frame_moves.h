// SPDX-License-Identifier: Apache-2.0
// How the adjustment of a submap with its camera moved the key frames. Poses that were given relative to them before
// were measured with another camera: the way from one key frame to the next was another one.
#pragma once

#include <cstdint>
#include <vector>

#include "covis/map/map.h"

namespace covis {

struct KeyFrameMove {
  KeyFrameId key_frame;
  int64_t frame = 0;  // KeyFrame::frame
  double scale = 1;   // KeyFrame::scale then
  SE3 before, after;  // T_cw
};

struct KeyFrameMoves {
  std::vector<KeyFrameMove> of;  // in any order; empty: what is relative to key frames need not follow
  uint64_t moves = 0;            // Map::moves() from then on
};

}  // namespace covis
