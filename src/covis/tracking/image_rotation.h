// SPDX-License-Identifier: Apache-2.0
// How the camera turned between two frames, from their small images alone: no features, no map, no motion before. All
// turns that leave a third of the view are searched. Parallax beyond that of moving forward is taken for a turn, and
// the lens for a pinhole; both are small beside the turns this is for. Source: Klein and Murray, "Improving the agility
// of keyframe-based SLAM", ECCV 2008, section 3; here the alignment ends over rotations and a zoom, which is exact for
// wide turns, and not over shifts and rolls of the image.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "covis/features/small_image.h"

namespace covis {

// R_21: first camera to second. `camera` is that of the full images. Nothing when the images are flat, too small, of
// different sizes, or do not correlate.
std::optional<Eigen::Matrix3d> image_rotation(const SmallImage& first, const SmallImage& second, const Pinhole& camera);

}  // namespace covis
