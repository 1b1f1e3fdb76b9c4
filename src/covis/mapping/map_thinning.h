// SPDX-License-Identifier: Apache-2.0
// Thins a saved map to a number of key frames, or of points: those go first whose loss costs least.
#pragma once

#include <cstddef>
#include <vector>

#include "covis/map/map.h"

namespace covis {

struct ThinnedKeyFrame {
  int64_t frame = 0;
  SE3 T_cw;
  uint32_t submap = 0;
  FeaturesPtr features;
};

// Erases key frames until so many are left, and points that too few see then (Map::erase_key_frame). Those go first
// whose loss costs least: a point that n key frames see counts 2^-(n-1). A key frame that others made dearer is weighed
// again before it goes; one that became cheaper, as its points were lost, keeps its old place in the order. Roots stay.
// Returns what was erased, in that order.
std::vector<ThinnedKeyFrame> thin_map(Map& map, size_t key_frames);

// Erases points until so many are left. Those go first that are matched seldom, that few key frames see, and these with
// many others: a point that is matched in a share of the frames that should see it costs that share of 1/n for each key
// frame that sees n points still. So every place keeps some.
void thin_points(Map& map, size_t points);

}  // namespace covis
