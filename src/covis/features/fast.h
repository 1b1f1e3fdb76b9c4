// SPDX-License-Identifier: Apache-2.0
// FAST-9/16 corners (Rosten and Drummond, "Machine learning for high-speed corner detection", ECCV 2006). The score of
// a corner is the greatest threshold at which it still is one, as in OpenCV's cv::FAST.
#pragma once

#include <vector>

#include "covis/core/image.h"

namespace covis {

struct Corner {
  int16_t x = 0, y = 0;
  uint8_t score = 0;
  float dx = 0,
        dy = 0;  // pixels from (x, y) to the top of the parabola through the neighbours' scores, within half a pixel
};

// Finds corners at least `border` pixels from the edge of the image (border >= 3), after 3x3 non-maximum suppression,
// row by row. In each of the cells (about cell_size wide) those above `threshold`; where there is none, those above
// `low_threshold`.
class FastDetector {
 public:
  void detect(ImageView<const uint8_t> image, int border, int cell_size, int threshold, int low_threshold,
              std::vector<Corner>& corners);

 private:
  ImageU8 scores_;  // scores of the rows above, at and below the current one
  std::vector<uint16_t> maxima_, cell_column_;
  std::vector<Corner> all_;
  std::vector<uint8_t> cell_has_;
};

// The score of one pixel (3 or more from the edge): 0 when it is no corner at `threshold`.
int fast_score(const uint8_t* pixel, ptrdiff_t stride, int threshold);

}  // namespace covis
