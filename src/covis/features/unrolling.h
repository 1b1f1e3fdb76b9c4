// SPDX-License-Identifier: Apache-2.0
// Keypoints of a rolling shutter: the rows of such an image are exposed one after the other, while the camera turns.
// Keypoints are moved to where they would have been seen in the moment of the row through the principal point. The
// translation of the camera stays in them: it would need their depth.
// Source: Forssén and Ringaby, "Rectifying rolling shutter video from hand-held devices", CVPR 2010, section 2.
#pragma once

#include "covis/features/features.h"
#include "covis/geometry/camera.h"

namespace covis {

// By how much a ray moves as rays turn by this rotation vector, radians.
inline Eigen::Vector3d moved_by_turn(const Eigen::Vector3d& ray, const Eigen::Vector3d& turn) {
  const Eigen::Vector3d moved = turn.cross(ray);
  return moved + 0.5 * turn.cross(moved);
}

// Takes the turn that `exposure` tells out of keypoints that have what their own `exposure` leaves in them.
void unroll(const Pinhole& camera, const ExposureTurn& exposure, Features& features);

}  // namespace covis
