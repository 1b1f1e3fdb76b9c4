// SPDX-License-Identifier: Apache-2.0
// The depth of a keypoint in a depth image. A keypoint close to an occluding edge is a corner of the nearer surface and
// moves with it, but its pixel often shows the farther surface. Such a depth would be too large, and with it every
// motion measured by it. Those keypoints therefore get no depth, and triangulation from several views decides.
#pragma once

#include "covis/core/image.h"
#include "covis/geometry/depth_registration.h"

namespace covis {

// A depth that something can have, in metres. Programs that render put 1e10 or the like where there is nothing.
inline bool is_depth(float z) { return z >= 1e-3f && z <= 1e4f; }

// Returns metres along z at (x, y), whose pixel must lie in the image, or 0 for no depth (none in the image, or close
// to an occluding edge). Between pixels of one surface the inverse depth is interpolated, which is
// right for planes. scale: image pixels per pixel of the keypoint's level.
float depth_at(ImageView<const float> depth, float x, float y, float scale);

// The same in a depth image that is registered so to the image of the keypoint. 0 also where its place lies outside, or
// is not clear, as nearer and farther surfaces compete for it. centre: the image's principal point.
float depth_at(ImageView<const float> depth, const DepthRegistration& registration, const Eigen::Vector2d& centre,
               float x, float y, float scale);

}  // namespace covis
