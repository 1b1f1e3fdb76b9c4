// SPDX-License-Identifier: Apache-2.0
// Tells whether an image shows the points that a map expects there, found as corners or not. In another light few
// corners are found again and fewer match, but what is around most points still looks alike: 76 to 96 % of their
// descriptors, made at the places where a right pose has them, and 5 % by chance. A thing of which there are several
// matches wherever one of them stands; the points around it do not. So it is asked how evenly points agree over the
// image. Measured: docs/notes/024-places-in-another-light.md.
#pragma once

#include <optional>
#include <vector>

#include "covis/features/image_probe.h"
#include "covis/geometry/se3.h"
#include "covis/map/map.h"

namespace covis {

class ShownPoints {
 public:
  // A view at this pose. camera: the map's.
  ShownPoints(const Pinhole& camera, const SE3& T_cw, const ImageBounds& bounds)
      : camera_(camera), T_cw_(T_cw), bounds_(bounds) {}

  // A point that should be in view is to be shown, if it was seen from about the same side before. Copies what is asked
  // of it, so that the map is not held while the image is looked at.
  void add(const MapPoint& point, const Map& map);
  // The mean over the blocks of the image of the root of the share of their points that agree, squared: 1 where all
  // agree, and less than that share where some blocks agree and others do not. There is none where too few could be
  // compared for it to say something.
  std::optional<double> even_share(const ImageProbe& image) const;

 private:
  struct Question {
    Descriptor descriptor;
    ImageProbe::Expected point;
  };

  Pinhole camera_;
  SE3 T_cw_;
  ImageBounds bounds_;
  std::vector<Question> questions_;
};

}  // namespace covis
