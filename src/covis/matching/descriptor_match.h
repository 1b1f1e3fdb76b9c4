// SPDX-License-Identifier: Apache-2.0
// Matching without a prediction of where: every descriptor of one image against every descriptor of the other.
// Source: the ratio test is Lowe's, "Distinctive Image Features from Scale-Invariant Keypoints", IJCV 2004,
// section 7.1; the check of orientations is that of Mur-Artal, Montiel, Tardós, "ORB-SLAM", T-RO 2015, section III-E.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "covis/features/features.h"

namespace covis {

struct DescriptorMatchOptions {
  int max_distance = kHammingLow;  // greatest Hamming distance of a match
  float ratio = 0.7f;              // best < ratio x second best
};

// Wide gates for matches that RANSAC sorts: 5 % more lost frames are found again than with 0.75 and 50.
inline constexpr DescriptorMatchOptions kForRansac{.max_distance = 64, .ratio = 0.9f};

struct FeatureMatch {
  int32_t a = 0, b = 0;  // indices of features
};

// Matches features of `a` (those with use_a[i] != 0; empty span: all) to features of `b` (likewise): nearest in both
// directions, better than the ratio asks, and turned as the bulk is (keep_consistent_rotations()). Sorted by a.
std::vector<FeatureMatch> match_descriptors(const Features& a, std::span<const uint8_t> use_a, const Features& b,
                                            std::span<const uint8_t> use_b, const DescriptorMatchOptions& options);

// Drops the matches whose change of orientation disagrees with the bulk (check_rotation in window_match.h).
void keep_consistent_rotations(const Features& a, const Features& b, std::vector<FeatureMatch>& matches);

}  // namespace covis
