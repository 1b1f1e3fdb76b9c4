// SPDX-License-Identifier: Apache-2.0
// Tells whether an image shows the points that a map expects there, found as corners or not. In another light few
// corners are found again and fewer match, but what is around most points still looks alike: 76 to 96 % of their
// descriptors, made at the places where a right pose has them, and 5 % by chance. A thing of which there are several
// matches wherever one of them stands; the points around it do not. So it is asked how evenly points agree over the
// image. Measured: docs/notes/024-places-in-another-light.md.
#pragma once

#include <array>
#include <cstddef>

#include "covis/features/image_probe.h"
#include "covis/geometry/se3.h"
#include "covis/map/map.h"

namespace covis {

class ShownPoints {
 public:
  // A view of the image at this pose. camera: the map's.
  ShownPoints(const ImageProbe& image, const Pinhole& camera, const SE3& T_cw, const ImageBounds& bounds)
      : image_(image), camera_(camera), T_cw_(T_cw), bounds_(bounds) {}

  // Compares a point that should be in view, if it was seen from about the same side before.
  void add(const MapPoint& point, const Map& map);
  // Enough points were compared for their share to say something.
  bool enough() const { return compared_ >= 60; }
  // The mean over the blocks of the image of the root of the share of their points that agree, squared: 1 where all
  // agree, and less than that share where some blocks agree and others do not.
  double even_share() const;

 private:
  static constexpr int kColumns = 10, kRows = 8;
  struct Block {
    int compared = 0, agree = 0;
  };

  const ImageProbe& image_;
  const Pinhole& camera_;
  const SE3 T_cw_;
  const ImageBounds bounds_;
  std::array<Block, size_t{kColumns} * kRows> blocks_;
  int compared_ = 0;
};

}  // namespace covis
