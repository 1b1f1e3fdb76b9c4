// SPDX-License-Identifier: Apache-2.0
// The structure tensor of a corner's surroundings. Along a straight edge a corner detector answers wherever the pixels
// happen to make a step; such a place slides along the edge from view to view. The tensor's eigenvalues tell: one of
// them is small there. Sources: Harris and Stephens, "A combined corner and edge detector", AVC 1988; the bound on
// their ratio: Lowe, "Distinctive image features from scale-invariant keypoints", IJCV 2004, section 4.1. Measured:
// docs/notes/026-corners-on-edges.md.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "covis/features/fast.h"

namespace covis {

// Sums over the 7x7 pixels around one of products of the differences of its neighbours: right less left (x), lower less
// upper (y).
struct GradientSums {
  int xx = 0, yy = 0, xy = 0;
  bool operator==(const GradientSums&) const = default;
};
// Sets the sums of `count` corners. The image must extend at least 5 pixels beyond each of them on every side.
void gradient_sums(ImageView<const uint8_t> image, const Corner* corners, size_t count, GradientSums* sums);

// True where the greater eigenvalue of the tensor is more than `ratio` times the smaller one.
bool lies_on_edge(const GradientSums& sums, double ratio);

// Erases the corners that lie on an edge.
void leave_out_edges(ImageView<const uint8_t> image, double ratio, std::vector<Corner>& corners);

}  // namespace covis
