// SPDX-License-Identifier: Apache-2.0
// FAST-9/16 corners (Rosten and Drummond, "Machine learning for high-speed corner detection", ECCV 2006). The score of
// a corner is the greatest threshold at which it is still detected, as in OpenCV's cv::FAST.
#pragma once

#include <vector>

#include "covis/core/image.h"

namespace covis {

struct Corner {
  int16_t x = 0, y = 0;
  uint8_t score = 0;
  uint8_t left = 0, right = 0, above = 0, below = 0;  // the neighbours' scores, all less

  // Sub-pixel offset from (x, y) to the maximum of the parabola through the neighbours' scores, at most 0.5. It is
  // asked only of the corners that the quadtree keeps.
  float dx() const { return peak(left, score, right); }
  float dy() const { return peak(above, score, below); }

 private:
  // Returns the maximum's offset from the middle of the parabola through three scores.
  static float peak(int before, int at, int after) {
    return 0.5f * static_cast<float>(after - before) / static_cast<float>(2 * at - before - after);
  }
};

// Finds corners at least `border` pixels from the image edge (border >= 3), with 3x3 non-maximum suppression, in row
// order. Each cell (about cell_size wide) gives its corners above `threshold` or, if it has none, those above
// `low_threshold`, which is not the greater one.
class FastDetector {
 public:
  void detect(ImageView<const uint8_t> image, int border, int cell_size, int threshold, int low_threshold,
              std::vector<Corner>& corners);

 private:
  // Appends the corners of a row of cells that are to be kept.
  void keep_of_row(int x0, int threshold, std::vector<Corner>& corners);

  ImageU8 scores_;  // scores of the rows above, at and below the current one
  std::vector<uint16_t> maxima_, column_of_;
  // The corners of the current row of cells, and for each column of cells a flag: its cell has one above the threshold.
  std::vector<Corner> in_row_;
  std::vector<uint8_t> has_strong_;
};

// Score of one pixel at least 3 pixels from the edge; 0 when it is no corner at `threshold`.
int fast_score(const uint8_t* pixel, ptrdiff_t stride, int threshold);

}  // namespace covis
