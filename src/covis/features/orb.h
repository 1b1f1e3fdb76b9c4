// SPDX-License-Identifier: Apache-2.0
// Orientation and descriptor of a corner. Source: Rublee, Rabaud, Konolige, Bradski, "ORB: an efficient alternative to
// SIFT or SURF", ICCV 2011, sections 3.2 (intensity centroid) and 4 (steered BRIEF pairs).
#pragma once

#include <array>
#include <cstdint>

#include "covis/core/image.h"
#include "covis/features/features.h"

namespace covis {

inline constexpr int kPatchRadius = 15;  // radius of the disc whose centroid gives the orientation, pixels
inline constexpr int kEdgeBorder = 19;   // least distance to the border, pixels, so that a rotated pattern stays inside

// Angle of the intensity centroid around `pixel`, radians in [0, 2 pi). The image must extend at least 15 pixels beyond
// it on every side, and 16 to the right.
float orientation(const uint8_t* pixel, ptrdiff_t stride);

// The pattern rotated by an angle, in images with this stride.
class TurnedPattern {
 public:
  TurnedPattern(float angle, ptrdiff_t stride);
  // The 256 comparisons around `pixel` of the blurred level, which must extend at least 19 pixels beyond it on every
  // side.
  Descriptor describe(const uint8_t* pixel) const;

 private:
  alignas(64) std::array<int32_t, 512> offset_;  // each comparison's two points, from the pixel
};

// The same for one pixel alone.
Descriptor describe(const uint8_t* pixel, ptrdiff_t stride, float angle);

}  // namespace covis
