// SPDX-License-Identifier: Apache-2.0
// The error that a pair's rectification left in the rows: how much lower than in the left image things are in the right
// one, found from the matches of the first pairs. Matches are sought in rows, and patches compared in them, so that
// rows that are off cost matches, and depth wherever depth changes from row to row, as on the ground. Measured figures:
// docs/notes/063-what-rectification-left.md.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "covis/features/rectification.h"
#include "covis/features/stereo_matcher.h"
#include "covis/geometry/camera.h"

namespace covis {

// By how much the column of a match is farther right than before.
struct ColumnDifference {
  float u = 0, v = 0;  // the right image's column, and the row
  float right = 0;     // pixels
};

class RightRows {
 public:
  // camera: the rectified one.
  explicit RightRows(const Camera& camera);

  // Takes in the matches of another pair, whose right image was resampled by the present field, if there is any. Gives
  // a better field where they show one: by its effect on them of 0.15 pixels at least, and five standard deviations.
  std::optional<ShiftField> add(std::span<const RowDifference> differences);
  // Takes it, when columns differ so between right images that were resampled by it and as before. False: they do not
  // say how over all of the image, and nothing is changed.
  bool take(const ShiftField& field, std::span<const ColumnDifference> differences);
  // None until one was taken.
  const ShiftField& field() const { return field_; }
  // The mean effect of resampling on columns, to be taken out as Pinhole::right_columns are. Rows that are off shift
  // disparities wherever depth changes from row to row, and the columns of a pair may have been calibrated with that:
  // motion alone says what they are (loops/columns_refinement.h).
  const ShiftField& columns() const { return columns_; }
  // "up to 1.3 pixels"
  std::string description() const;
  // Makes a right image as if its rows were those of the left one.
  ResamplingMap resampling(const ShiftField& field) const;

 private:
  const Camera camera_;
  std::vector<RowDifference> differences_;  // since the field was asked for last
  size_t round_ = 0;                        // how often it was
  ShiftField field_, columns_;
};

}  // namespace covis
