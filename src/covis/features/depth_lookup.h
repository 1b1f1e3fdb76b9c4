// SPDX-License-Identifier: Apache-2.0
// The depth of a keypoint in a depth image. A keypoint close to the outline of something nearer is a corner of that
// outline: its pixel often shows what lies behind, and it moves with what lies before. Taken at its word, such depth is
// too large, and so is every motion measured by it. So there is none there, and views from several places decide.
#pragma once

#include "covis/core/image.h"

namespace covis {

// Metres along z at pixel (x, y), which lies in the image; 0: none (0, negative or not finite in the image, or close to
// the outline of something nearer). scale: of the keypoint's level, image pixels a pixel of the level.
float depth_at(ImageView<const float> depth, int x, int y, float scale);

}  // namespace covis
