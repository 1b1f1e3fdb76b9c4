// SPDX-License-Identifier: Apache-2.0
// The error that a pair's rectification left in the rows: how much lower than in the left image things are in the right
// one, found from the matches of the first pairs. Matches are sought in rows, and patches compared in them, so that
// rows that are off cost matches, and depth wherever depth changes from row to row, as on the ground. Measured figures:
// docs/notes/063-what-rectification-left.md.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "covis/features/rectification.h"
#include "covis/features/stereo_matcher.h"
#include "covis/geometry/camera.h"

namespace covis {

class RightRows {
 public:
  // camera: the rectified one.
  explicit RightRows(const Camera& camera);

  // Takes in the matches of another pair, whose right image was resampled by resampling() where there is a field. True:
  // the field has changed.
  bool add(std::span<const RowDifference> differences);
  // None until matches show one: by its effect on them of 0.15 pixels at least, and five standard deviations.
  const ShiftField& field() const { return field_; }
  // "up to 1.3 pixels"
  std::string description() const;
  // Makes a right image as if its rows were those of the left one.
  ResamplingMap resampling() const;

 private:
  const Camera camera_;
  std::vector<RowDifference> differences_;  // since the field was asked for last
  size_t round_ = 0;                        // how often it was
  ShiftField field_;
};

}  // namespace covis
