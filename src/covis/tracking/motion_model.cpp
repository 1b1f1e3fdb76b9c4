// SPDX-License-Identifier: Apache-2.0
#include "covis/tracking/motion_model.h"

#include <cmath>

namespace covis {

void MotionModel::observe(const SE3& T_21, Timestamp elapsed) {
  if (!usual_.is_burst(elapsed)) {
    motion_ = {T_21, elapsed};
  } else if (motion_) {
    motion_ = {(T_21 * motion_->T_21).normalized(), motion_->elapsed + elapsed};
  }
}

void MotionModel::rescale(double growth) {
  if (motion_) motion_->T_21 = SE3(motion_->T_21.R(), Eigen::Vector3d(growth * motion_->T_21.t()));
}

bool MotionModel::is_pause(Timestamp elapsed) const {
  constexpr double kPause = 5;  // times the step before: after a longer pause the camera may have gone anywhere
  return motion_ && std::abs(static_cast<double>(elapsed)) > kPause * std::abs(static_cast<double>(motion_->elapsed));
}

std::optional<SE3> MotionModel::predict(Timestamp elapsed) const {
  constexpr double kJitter = 1.4;  // a smaller ratio of times is jitter of the stamps, and not frames left out
  if (!motion_ || is_pause(elapsed)) return std::nullopt;
  const double times = static_cast<double>(elapsed) / static_cast<double>(motion_->elapsed);
  return times < kJitter && times > 1 / kJitter ? motion_->T_21 : SE3::exp(times * motion_->T_21.log());
}

Eigen::Vector3d MotionModel::turn_rate(const SE3& T_21, Timestamp elapsed) {
  return SE3(T_21.R(), Eigen::Vector3d::Zero()).log().tail<3>() / to_seconds(elapsed);
}

}  // namespace covis
