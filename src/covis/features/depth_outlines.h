// SPDX-License-Identifier: Apache-2.0
// Whether the outlines in depth images lie where their images have edges. A depth image that is registered to its image
// fits best as it is; one that is shifted, mirrored, upside down or turned round fits better elsewhere, in every single
// frame and without motion. Measured: docs/notes/040-depth-that-contradicts-the-map.md.
//
// Images and depth are looked at in cells, some 80 of them side by side. An outline is a step of depth between cells; an
// edge is a gradient of the image by its surroundings. The fit of a displacement is the sum of the edges under all
// outlines, in standard deviations of such a sum.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "covis/core/image.h"

namespace covis {

struct OutlineFit {
  double here = 0;       // the best fit within 4 % of the image's width
  double elsewhere = 0;  // the best fit displaced by more than 10 %, mirrored, upside down or turned round

  // True when depth belongs elsewhere: more than twice as good, and more than chance gives in any scene.
  bool is_displaced() const;
  double ratio() const;  // how many times better
};

// Keeps its work space between frames.
class DepthOutlines {
 public:
  // Of the same size. Every second frame is looked at, and after every tenth of these there is an answer.
  std::optional<OutlineFit> add(ImageView<const uint8_t> image, ImageView<const float> depth);

 private:
  struct Outline {
    int x = 0, y = 0;  // cells
    float weight = 0;
  };
  // The depth, or its outlines, as if it were mirrored along x and y.
  struct Displacement {
    int dx = 0, dy = 0;  // cells
    bool flip_x = false, flip_y = false;
    bool is_here = false;
    double sum = 0, squares = 0;
  };
  void start(ImageView<const uint8_t> image);
  void find_outlines(ImageView<const float> depth);
  void find_edges(ImageView<const uint8_t> image);
  void fit();
  OutlineFit answer();

  int block_ = 0, width_ = 0, height_ = 0;  // pixels of a cell's side; cells
  size_t frames_ = 0, looked_at_ = 0;
  std::vector<float> grey_, depth_, edge_, mean_;  // by cell; depth 0: none
  std::vector<Outline> outlines_;
  std::vector<Displacement> displacements_;
};

}  // namespace covis
