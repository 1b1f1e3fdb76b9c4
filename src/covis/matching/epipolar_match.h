// SPDX-License-Identifier: Apache-2.0
// Matching two key frames of known pose along epipolar lines, to triangulate new points.
// Source: Mur-Artal, Montiel, Tardós, "ORB-SLAM", T-RO 2015, section VI-C; epipolar geometry: Hartley and Zisserman,
// "Multiple View Geometry", 2004, section 9.6; ratio test: Lowe, "Distinctive image features", IJCV 2004, section 7.1.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "covis/features/features.h"
#include "covis/geometry/camera.h"
#include "covis/geometry/se3.h"
#include "covis/matching/descriptor_match.h"

namespace covis {

struct EpipolarMatchOptions {
  int max_distance = kHammingLow;  // greatest Hamming distance of a match
  // Greatest distance relative to that of any other feature on the line that is farther away than the margin below; 1:
  // any.
  double max_ratio = 1;
  double rival_margin = 8;  // pixels x scale around the best within which another one is no rival
  double max_chi2 = 3.84;   // squared distance to the line over sigma^2 (1 degree of freedom, 95 %)
  // Pixels x scale around the epipole within which nothing is matched, unless one of the two features has depth.
  double epipole_margin = 10;
};

// Matches features of `a` (those with use_a[i] != 0) to features of `b` (likewise) that lie near their epipolar lines.
// T_ba takes camera a to camera b, both of the same intrinsics. Each feature of b at most once (the most similar).
// Matches that turned otherwise than the bulk are dropped. Sorted by a.
std::vector<FeatureMatch> match_epipolar(const Pinhole& camera, const Features& a, std::span<const uint8_t> use_a,
                                         const Features& b, std::span<const uint8_t> use_b, const SE3& T_ba,
                                         const EpipolarMatchOptions& options);

}  // namespace covis
