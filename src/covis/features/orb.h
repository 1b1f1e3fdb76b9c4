// SPDX-License-Identifier: Apache-2.0
// Orientation and descriptor of a corner. Source: Rublee, Rabaud, Konolige, Bradski, "ORB: an efficient alternative to
// SIFT or SURF", ICCV 2011, sections 3.2 (intensity centroid) and 4 (steered BRIEF pairs).
#pragma once

#include "covis/core/image.h"
#include "covis/features/features.h"

namespace covis {

inline constexpr int kPatchRadius = 15;  // radius of the disc whose centroid gives the orientation
inline constexpr int kEdgeBorder = 19;   // pixels clear of the border, so that a rotated pattern stays inside

// Angle of the intensity centroid round `pixel`, radians in [0, 2 pi). 15 pixels must be there on all sides, 16 to the
// right.
float orientation(const uint8_t* pixel, ptrdiff_t stride);

// The 256 comparisons round `pixel` of the blurred level, turned by `angle`. 19 pixels must be there on all sides.
Descriptor describe(const uint8_t* pixel, ptrdiff_t stride, float angle);

}  // namespace covis
