// SPDX-License-Identifier: Apache-2.0
#include "covis/api/rectifier.h"

#include "covis/api/convert.h"

namespace covis {

Result<Rectifier> Rectifier::create(const Camera& left, const RightCamera& right) {
  const SE3 T_rl = to_se3(right.pose).inverse();
  auto rectification = StereoRectification::create(left, to_camera(right.camera, SensorType::monocular), T_rl);
  if (!rectification) return tl::unexpected(rectification.error());
  return Rectifier(std::move(*rectification));
}

Pose Rectifier::rectified_left() const { return to_pose(rectification_.T_left_rectified()); }

void Rectifier::rectify(ImageView<const uint8_t>& left, ImageView<const uint8_t>& right) {
  rectification_.left(left, left_);
  rectification_.right(right, right_);
  left = left_.view();
  right = right_.view();
}

}  // namespace covis
