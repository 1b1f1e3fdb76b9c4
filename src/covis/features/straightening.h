// SPDX-License-Identifier: Apache-2.0
// Features as a camera that was refined has them: keypoints without its residual distortion (ResidualDistortion) and
// without the turn between the rows of its rolling shutter (Pinhole::row_time), and, in key frames that keep their
// depth images, depths looked up by its registration (DepthRegistration).
#pragma once

#include <memory>

#include "covis/features/features.h"

namespace covis {

// The keypoints are free of this camera's residual distortion and, where it is known, of the turn between its rows, and
// depths that can be looked up again are those of its registration.
bool straight_for(const Features& features, const Pinhole& camera);

// The same features as this camera has them, instead of another one. A keypoint stays where it is when no ray shows
// there, so that it would leave all bounds.
std::shared_ptr<Features> straightened(const Features& features, const Pinhole& camera);

// A copy for a key frame of a map with this camera. depth: to be kept with it, may be null. turn_rate: of the rays,
// radians a second; zero: not known.
std::shared_ptr<Features> key_frame_features(const Features& features, std::shared_ptr<const KeptDepth> depth,
                                             const Eigen::Vector3d& turn_rate, const Pinhole& camera);

// The bounding box of what an image's border becomes.
ImageBounds straightened(const ImageBounds& bounds, const Pinhole& camera);

}  // namespace covis
