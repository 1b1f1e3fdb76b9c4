// SPDX-License-Identifier: Apache-2.0
// Rectification of a calibrated stereo pair: both images are resampled as if taken by two equal pinhole cameras side by
// side. Source: Fusiello, Trucco, Verri, "A compact algorithm for rectification of stereo pairs", MVA 2000.
#pragma once

#include <memory>

#include "covis/core/error.h"
#include "covis/core/image.h"
#include "covis/geometry/camera.h"
#include "covis/geometry/se3.h"

namespace covis::io {

class StereoRectification {
 public:
  // T_rl takes the left camera to the right one. An error when the right camera is not to the right of the left one.
  static Result<StereoRectification> create(const Camera& left, const Camera& right, const SE3& T_rl);

  const Camera& camera() const { return camera_; }  // camera of the rectified images, bf filled in
  const SE3& T_left_rectified() const {
    return T_left_rectified_;
  }  // rectified left camera to left camera (a rotation)
  // In place of the image as it came; `scratch` is memory that is used again.
  void left(ImageU8& image, ImageU8& scratch) const { apply(*maps_[0], image, scratch); }
  void right(ImageU8& image, ImageU8& scratch) const { apply(*maps_[1], image, scratch); }

 private:
  struct Maps;
  static void apply(const Maps& maps, ImageU8& image, ImageU8& scratch);

  Camera camera_;
  SE3 T_left_rectified_;
  std::shared_ptr<const Maps> maps_[2];
};

}  // namespace covis::io
