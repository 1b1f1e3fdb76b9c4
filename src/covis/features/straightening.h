// SPDX-License-Identifier: Apache-2.0
// Keypoints without the residual distortion of a refined camera (ResidualDistortion).
#pragma once

#include <memory>

#include "covis/features/features.h"

namespace covis {

// The keypoints are free of this camera's residual distortion.
bool straight_for(const Features& features, const Pinhole& camera);

// The same keypoints, free of this camera's residual distortion instead of another one's. A keypoint that it takes out
// of all bounds, as no ray shows there, stays where it is.
std::shared_ptr<Features> straightened(const Features& features, const Pinhole& camera);

// A copy for a key frame of a map with this camera.
std::shared_ptr<Features> key_frame_features(const Features& features, const Pinhole& camera);

// The bounding box of what an image's border becomes.
ImageBounds straightened(const ImageBounds& bounds, const Pinhole& camera);

}  // namespace covis
