// SPDX-License-Identifier: Apache-2.0
#include "covis/features/unrolling.h"

#include <algorithm>

namespace covis {

void unroll(const Pinhole& camera, const Eigen::Vector3d& turn, Features& f) {
  if (f.raw_x.empty()) {
    f.raw_x = f.x;
    f.raw_y = f.y;
  }
  ImageBounds bounds = f.grid.bounds;
  for (size_t i = 0; i < f.x.size(); ++i) {
    const double rows = f.raw_y[i] - camera.cy;
    const Eigen::Vector3d ray = camera.unproject(f.x[i], f.y[i]);
    const Eigen::Vector2f at = camera.project(ray + moved_by_turn(ray, -rows * turn)).cast<float>();
    f.u_right[i] += f.u_right[i] >= 0 ? at.x() - f.x[i] : 0;
    f.x[i] = at.x();
    f.y[i] = at.y();
    bounds = {std::min(bounds.min_x, at.x()), std::min(bounds.min_y, at.y()), std::max(bounds.max_x, at.x()),
              std::max(bounds.max_y, at.y())};
  }
  f.grid.build(bounds, f.x, f.y);
  f.unrolled = true;
}

}  // namespace covis
