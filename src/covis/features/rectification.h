// SPDX-License-Identifier: Apache-2.0
// Rectification of a calibrated stereo pair: both images are resampled as if taken by two equal pinhole cameras side by
// side. Source: Fusiello, Trucco, Verri, "A compact algorithm for rectification of stereo pairs", MVA 2000.
#pragma once

#include <cstdint>
#include <vector>

#include "covis/core/error.h"
#include "covis/core/image.h"
#include "covis/geometry/camera.h"
#include "covis/geometry/se3.h"

namespace covis {

// For each pixel of an image to be made, the place in another image that it shows. Places are kept in steps of 1/32
// pixel and images are interpolated bilinearly in whole numbers, so that the bytes are those of OpenCV's remap
// (INTER_LINEAR, BORDER_CONSTANT 0).
class ResamplingMap {
 public:
  static constexpr int kLargestSide = 32767;  // pixels, of both images

  ResamplingMap() = default;
  ResamplingMap(int width, int height, int from_width, int from_height);

  // Lets pixel (u, v) show the place (x, y) of the other image, in pixels. What lies outside that image is black, and
  // a place that is not a number lies outside.
  void set(int u, int v, float x, float y);
  // Fills `to` from an image of from_width x from_height (asserted). `to` must not be the memory of `from`.
  void apply(ImageView<const uint8_t> from, ImageU8& to) const;

 private:
  static constexpr uint16_t kBorder = 1024;
  struct Place {
    int16_t x = -1, y = -1;       // the upper left of the four pixels around the place
    uint16_t fraction = kBorder;  // 32nds of a pixel from there, 32 y + x; plus kBorder: some of the four lie outside
  };

  static uint8_t at_border(ImageView<const uint8_t> from, Place place);

  int width_ = 0, height_ = 0, from_width_ = 0, from_height_ = 0;
  std::vector<Place> places_;
};

class StereoRectification {
 public:
  // T_rl maps left to right camera coordinates. Fails when the right camera is not to the right of the left one, or the
  // images are not of one size that ResamplingMap can have.
  static Result<StereoRectification> create(const Camera& left, const Camera& right, const SE3& T_rl);

  const Camera& camera() const { return camera_; }  // camera of the rectified images, including bf
  // Rotation from the rectified left camera to the left camera.
  const SE3& T_left_rectified() const { return T_left_rectified_; }
  // Rectifies an image of the cameras' size (asserted; readers check it before). Nothing is allocated once `to` has
  // had that size.
  void left(ImageView<const uint8_t> from, ImageU8& to) const { left_.apply(from, to); }
  void right(ImageView<const uint8_t> from, ImageU8& to) const { right_.apply(from, to); }

 private:
  Camera camera_;
  SE3 T_left_rectified_;
  ResamplingMap left_, right_;
};

}  // namespace covis
