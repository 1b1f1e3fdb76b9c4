// SPDX-License-Identifier: Apache-2.0
// Rectifies the stereo pairs of a program into memory of its own.
#pragma once

#include "covis/covis.h"
#include "covis/features/rectification.h"

namespace covis {

class Rectifier {
 public:
  // Fails when the cameras are not side by side, or their images of two sizes.
  static Result<Rectifier> create(const Camera& left, const RightCamera& right);

  const Camera& camera() const { return rectification_.camera(); }
  // The pose of the rectified left camera in the given one's coordinates.
  Pose rectified_left() const;
  // The views become those of the rectified images, which the next call overwrites.
  void rectify(ImageView<const uint8_t>& left, ImageView<const uint8_t>& right);
  // Rectifies an image of the left camera alone.
  void left(ImageView<const uint8_t> from, ImageU8& to) const { rectification_.left(from, to); }

 private:
  explicit Rectifier(StereoRectification rectification) : rectification_(std::move(rectification)) {}

  StereoRectification rectification_;
  ImageU8 left_, right_;
};

}  // namespace covis
