// SPDX-License-Identifier: Apache-2.0
// Matches the keypoints of a rectified pair along image rows (algorithms.md §1; ORB-SLAM2, T-RO 2017, section III-A).
#pragma once

#include <vector>

#include "covis/features/extractor.h"

namespace covis {

// How much lower than in the left image a corner is in the right one.
struct RowDifference {
  float u = 0, v = 0;  // the right image's column, the left image's row
  float lower = 0;     // pixels
};

class StereoMatcher {
 public:
  // Gives for each left keypoint its column in the right image (sub-pixel) or -1, and its depth in metres or 0. The
  // camera's right_columns are taken out of both.
  void match(const OrbExtractor& left, const OrbExtractor& right, const Pinhole& camera, AlignedVector<float>& u_right,
             AlignedVector<float>& depth);
  // Those of the last call's matches of fine levels, whose corners are placed well.
  const std::vector<RowDifference>& row_differences() const { return row_differences_; }
  // Median distance between the rows of the keypoints matched last, in sigmas of the right one; 0 without matches. Of a
  // rectified pair it is 0.3 to 0.5; rows that have nothing to do with each other give 1, half of the search's reach.
  double row_error() const { return row_error_; }

 private:
  std::vector<uint32_t> row_offsets_, row_items_, next_;
  std::vector<std::pair<int, uint32_t>> accepted_;  // SAD and index of the left keypoint
  std::vector<float> row_distances_;                // one for each accepted match, in sigmas
  std::vector<RowDifference> row_differences_;
  double row_error_ = 0;
};

}  // namespace covis
