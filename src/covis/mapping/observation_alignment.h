// SPDX-License-Identifier: Apache-2.0
// Refines the places of keypoints that show map points (matching/patch_alignment.h), each by the patch of its point's
// reference. Key frames have patches for all their keypoints while they are new, keep those of points whose reference
// they are, and lose these once many others have come.
#pragma once

#include "covis/map/shared_map.h"

namespace covis {

// Aligns what the newest key frame and the other new ones show since they were aligned last, and takes the patches
// from those that are not new any more. For the one thread that writes to the map.
void align_observations(SharedMap& map, KeyFrameId newest);

}  // namespace covis
