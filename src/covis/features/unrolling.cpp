// SPDX-License-Identifier: Apache-2.0
#include "covis/features/unrolling.h"

#include <algorithm>

namespace covis {
namespace {

// turn: to be taken out, from row to row, radians.
Eigen::Vector2d unrolled_place(const Pinhole& camera, const Eigen::Vector3d& turn, const Features& f, size_t i) {
  const double rows = f.image_y()[i] - camera.cy;
  const Eigen::Vector3d ray = camera.unproject(f.x[i], f.y[i]);
  return camera.project(ray + moved_by_turn(ray, -rows * turn));
}

}  // namespace

void unroll(const Pinhole& camera, const ExposureTurn& exposure, Features& f) {
  if (f.raw_x.empty()) {
    f.raw_x = f.x;
    f.raw_y = f.y;
  }
  const Eigen::Vector3d turn = exposure.taken() - f.exposure.taken();
  f.exposure = exposure;
  ImageBounds bounds = f.grid.bounds;
  for (size_t i = 0; i < f.x.size(); ++i) {
    const Eigen::Vector2f at = unrolled_place(camera, turn, f, i).cast<float>();
    f.u_right[i] += f.u_right[i] >= 0 ? at.x() - f.x[i] : 0;
    f.x[i] = at.x();
    f.y[i] = at.y();
    bounds = {std::min(bounds.min_x, at.x()), std::min(bounds.min_y, at.y()), std::max(bounds.max_x, at.x()),
              std::max(bounds.max_y, at.y())};
  }
  f.grid.build(bounds, f.x, f.y);
}

Eigen::Vector2d rolled_place(const Pinhole& camera, const Features& f, size_t i) {
  return unrolled_place(camera, -f.exposure.taken(), f, i);
}

}  // namespace covis
