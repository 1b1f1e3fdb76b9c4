// SPDX-License-Identifier: Apache-2.0
// Observations whose places were refined by the patch of one keypoint, their anchor, agree to a fraction of a pixel:
// whatever that keypoint showed, they show the same. Between two anchors of one point lies the error of a corner.
#pragma once

#include <cstdint>

#include "covis/map/map.h"

namespace covis {

// The serial of the key frame with whose patch a feature of a point was aligned: its own where it was not.
inline uint32_t anchor_of(const KeyFrame& key_frame, uint32_t feature) {
  const AlignedVector<uint32_t>& anchor = key_frame.features->anchor;
  return anchor.empty() || anchor[feature] == 0 ? key_frame.serial : anchor[feature] - 1;
}

}  // namespace covis
