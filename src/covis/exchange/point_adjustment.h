// SPDX-License-Identifier: Apache-2.0
// The positions of points by the pixels of an export.
#pragma once

#include "covis/exchange/scene.h"

namespace covis::exchange {

// Moves each point to where its keypoints, all of equal weight as they are for COLMAP, and its measured depths want it;
// poses stay. Robust: Huber's loss.
void adjust_points(Scene& scene);

}  // namespace covis::exchange
