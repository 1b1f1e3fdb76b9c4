// SPDX-License-Identifier: Apache-2.0
// For tests: keypoints as a rolling shutter sees them.
#pragma once

#include <algorithm>

#include "covis/features/unrolling.h"

namespace covis {

// Moves keypoints to where they are seen as the rays turn by this rotation vector from one row to the next.
inline void roll(const Pinhole& camera, const Eigen::Vector3d& turn, Features& features) {
  ImageBounds bounds = features.grid.bounds;
  for (size_t i = 0; i < features.x.size(); ++i) {
    const Eigen::Vector3d ray = camera.unproject(features.x[i], features.y[i]);
    Eigen::Vector2d at(features.x[i], features.y[i]);
    for (int k = 0; k < 5; ++k) at = camera.project(ray + moved_by_turn(ray, (at.y() - camera.cy) * turn));
    if (features.has_depth(static_cast<int>(i))) features.u_right[i] += static_cast<float>(at.x()) - features.x[i];
    features.x[i] = static_cast<float>(at.x());
    features.y[i] = static_cast<float>(at.y());
    bounds = {std::min(bounds.min_x, features.x[i]), std::min(bounds.min_y, features.y[i]),
              std::max(bounds.max_x, features.x[i]), std::max(bounds.max_y, features.y[i])};
  }
  features.grid.build(bounds, features.x, features.y);
}

}  // namespace covis
