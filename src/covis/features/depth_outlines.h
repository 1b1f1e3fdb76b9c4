// SPDX-License-Identifier: Apache-2.0
// Tests that the outlines in depth images lie on edges of their images. A depth image that is registered to its image
// fits best as it is; one that is shifted, mirrored, upside down or turned round fits better elsewhere, in every single
// frame and without motion. Measured: docs/notes/040-depth-that-contradicts-the-map.md.
//
// Images and depth are looked at in cells, some 80 of them side by side. An outline is a step of depth between cells,
// other than that of a surface at a slant; an edge is a gradient of the image by its surroundings. The fit of a
// displacement is the sum of the edges under all outlines, in standard deviations of such a sum. All sums are of
// integers: the same whatever adds them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "covis/core/image.h"

namespace covis {

struct OutlineFit {
  // A place at which depth is laid over the image: scaled around its middle, mirrored where a scale is negative, and
  // moved.
  struct Place {
    float scale_x = 1, scale_y = 1;
    int x = 0, y = 0;  // cells

    bool is_at(const Place& other) const;  // the same, to a cell
    bool has_another_size() const;
    bool is_mirrored() const { return scale_x < 0 || scale_y < 0; }
    bool is_about_as_large(const Place& other) const;  // by a factor of 1.3
  };

  double here = 0;  // the best fit within 4 % of the image's width
  // The best fit displaced by more than 10 %, mirrored, upside down, turned round or another size by a quarter or more.
  double elsewhere = 0;
  int outlines = 0;      // the number in all frames; a few fit nowhere well
  Place place{};         // the place of the best fit elsewhere
  bool new_view = true;  // false: the view is still that of the last answer of a new one, which it repeats

  double ratio() const;  // how many times better
  bool tells_much() const;
};

// Keeps its work space between frames.
class DepthOutlines {
 public:
  // Both have the same size. After every fifth frame there is an answer.
  std::optional<OutlineFit> add(ImageView<const uint8_t> image, ImageView<const float> depth);

 private:
  struct Outline {
    int x = 0, y = 0;  // cells
  };
  // Places of one scale, displaced by up to reach_x and reach_y cells.
  struct Displacements {
    float scale_x = 1, scale_y = 1;
    int reach_x = 0, reach_y = 0;
    int columns = 0;             // displacements side by side, and some more to fill registers
    std::vector<int16_t> sums;   // edges under the outlines of this frame
    std::vector<int32_t> total;  // frames since the last answer
  };
  void start(ImageView<const uint8_t> image);
  void find_outlines(ImageView<const float> depth);
  void average(ImageView<const uint8_t> image);
  void find_edges();
  void fit(Displacements& all);
  bool is_new_view();
  OutlineFit answer();

  int block_ = 0, width_ = 0, height_ = 0;  // pixels of a cell's side; cells
  int stride_ = 0;                          // cells from row to row of edge_
  size_t frames_ = 0;
  std::vector<float> depth_;       // by cell; 0: none
  std::vector<uint16_t> columns_;  // sums over the rows of one cell
  std::vector<int32_t> grey_;      // by cell, in eighths
  std::vector<int32_t> viewed_;    // grey_ at the last answer of a new view
  std::vector<int32_t> gradient_, along_rows_, around_;
  std::vector<int16_t> edge_;  // by cell, with a margin without edges
  std::vector<Outline> outlines_;
  std::vector<Displacements> displacements_;
  int counted_ = 0;      // outlines since the last answer
  double variance_ = 0;  // squares, expected of the sums
};

}  // namespace covis
