// SPDX-License-Identifier: Apache-2.0
#include "covis/features/unrolling.h"

#include <algorithm>

namespace covis {
namespace {

// turn: to be taken out, from row to row, radians. A keypoint at the edge of a wide view that it would move out of the
// camera's sight stays in its place.
Eigen::Vector2d unrolled_place(const Pinhole& camera, const Eigen::Vector3d& turn, const Features& f, size_t i) {
  constexpr double kLeast = 0.1;  // of the ray along the optical axis, which was 1
  const double rows = f.image_y()[i] - camera.cy;
  const Eigen::Vector3d ray = camera.unproject(f.x[i], f.y[i]);
  const Eigen::Vector3d turned = ray + moved_by_turn(ray, -rows * turn);
  return turned.z() > kLeast ? camera.project(turned) : Eigen::Vector2d(f.x[i], f.y[i]);
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
    f.u_right[i] += f.has_depth(static_cast<int>(i)) ? at.x() - f.x[i] : 0;
    f.x[i] = at.x();
    f.y[i] = at.y();
    bounds = {std::min(bounds.min_x, at.x()), std::min(bounds.min_y, at.y()), std::max(bounds.max_x, at.x()),
              std::max(bounds.max_y, at.y())};
  }
  f.grid.build(bounds, f.x, f.y);
}

}  // namespace covis
