// SPDX-License-Identifier: Apache-2.0
// A small blurred image of a frame, some 1200 pixels of any aspect: enough to tell how the camera turned, when features
// cannot. Source: Klein and Murray, "Improving the agility of keyframe-based SLAM", ECCV 2008, section 3.
#pragma once

#include <cstdint>
#include <vector>

#include "covis/core/image.h"
#include "covis/geometry/camera.h"

namespace covis {

// Each of its pixels is the mean of a square of image pixels, blurred. The image is as the lens made it: distorted.
struct SmallImage {
  int width = 0, height = 0;
  int block = 0;              // side of the squares, image pixels
  int left = 0, top = 0;      // the first image pixel that is covered
  std::vector<uint8_t> grey;  // row by row

  // The pinhole camera of these pixels, given that of the image.
  Pinhole camera(const Pinhole& of_image) const;
};

// Keeps its work space between images.
class SmallImageMaker {
 public:
  void make(ImageView<const uint8_t> image, SmallImage& small);

 private:
  void average(ImageView<const uint8_t> image, SmallImage& small);
  void blur(SmallImage& small);

  std::vector<uint16_t> columns_;  // sums of the image's columns over one row of squares
  std::vector<uint8_t> padded_;    // a line of the small image with its ends repeated
};

}  // namespace covis
