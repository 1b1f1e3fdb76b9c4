// SPDX-License-Identifier: Apache-2.0
// Keypoints without the residual distortion of a refined camera (ResidualDistortion).
#pragma once

#include <memory>

#include "covis/features/features.h"

namespace covis {

// The keypoints are free of this camera's residual distortion.
bool straight_for(const Features& features, const Pinhole& camera);

// The same keypoints, free of this camera's residual distortion instead of another one's. A keypoint stays where it is
// when no ray shows there, so that it would leave all bounds.
std::shared_ptr<Features> straightened(const Features& features, const Pinhole& camera);

// A copy for a key frame of a map with this camera.
std::shared_ptr<Features> key_frame_features(const Features& features, const Pinhole& camera);

// The bounding box of what an image's border becomes.
ImageBounds straightened(const ImageBounds& bounds, const Pinhole& camera);

}  // namespace covis
