// SPDX-License-Identifier: Apache-2.0
// Thins a map to a number of key frames, or of points: those go first whose loss costs least.
#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "covis/map/map.h"

namespace covis {

struct ThinnedKeyFrame {
  int64_t frame = 0;
  SE3 T_cw;
  uint32_t submap = 0;
  FeaturesPtr features;
};

// Up to so many key frames for which `may_go` is true, those first whose loss costs least: a point that n key frames
// see counts 2^-(n-1), without those that were chosen before. One that they made dearer is weighed again before it is
// chosen; one that became cheaper, as its points would be lost, keeps its old place in the order. Roots are never
// chosen, and those with loop edges last.
std::vector<KeyFrameId> expendable_key_frames(const Map& map, size_t count,
                                              const std::function<bool(KeyFrameId)>& may_go);

// Erases such key frames until so many are left, and points that too few see then (Map::erase_key_frame). Returns what
// was erased, in that order.
std::vector<ThinnedKeyFrame> thin_map(Map& map, size_t key_frames);

// Erases points until so many are left. Those go first that are matched seldom, that few key frames see, and these with
// many others: a point that is matched in a share of the frames that should see it costs that share of 1/n for each key
// frame that sees n points still. So every place keeps some.
void thin_points(Map& map, size_t points);

}  // namespace covis
