// SPDX-License-Identifier: Apache-2.0
// Depth images that no longer change while their images do: a driver that repeats the last one. A depth camera's noise
// makes every depth image another, also of a scene that stands. Measured: docs/notes/044-depth-doubted-sooner.md.
#pragma once

#include <cstdint>
#include <vector>

#include "covis/core/image.h"

namespace covis {

class FrozenDepth {
 public:
  // Each frame. Returns the number of depth images in a row, this one and those before it, that are equal where they
  // were looked at, or 0 while there are few or the image is still about the one that they began with, brighter or not.
  int add(ImageView<const uint8_t> image, ImageView<const float> depth);

 private:
  bool equals_last(ImageView<const float> depth);
  void average(ImageView<const uint8_t> image);

  std::vector<float> depth_;    // depths of some pixels
  std::vector<int32_t> grey_;   // means of blocks of this frame's image
  std::vector<int32_t> first_;  // the same when depth was first repeated
  int equal_ = 0;
};

}  // namespace covis
