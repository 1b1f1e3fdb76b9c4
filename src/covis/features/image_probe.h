// SPDX-License-Identifier: Apache-2.0
// Compares descriptors with what an image shows at any of its places, whether or not a corner was found there.
#pragma once

#include <optional>

#include "covis/features/features.h"
#include "covis/geometry/camera.h"

namespace covis {

class OrbExtractor;

class ImageProbe {
 public:
  // camera: that of the extractor's images. Both must outlive this.
  ImageProbe(const Camera& camera, const OrbExtractor& extractor) : camera_(camera), extractor_(extractor) {}

  // A point as the image is expected to show it.
  struct Expected {
    Eigen::Vector3d p_c = Eigen::Vector3d::Zero();  // in the camera, metres
    float scale = 1;                                // that of the pyramid level whose pixels show what was described
    float angle = 0;                                // orientation in the image, radians
  };
  // The least Hamming distance of a descriptor to those of the 3x3 pixels of its level around where the extractor's
  // last image shows the point. `refined`: the camera as the map has it. Nothing: the image does not show it, or too
  // near to its border.
  std::optional<int> distance(const Descriptor& descriptor, const Expected& point, const Pinhole& refined) const;

 private:
  const Camera& camera_;
  const OrbExtractor& extractor_;
};

}  // namespace covis
