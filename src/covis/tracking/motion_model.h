// SPDX-License-Identifier: Apache-2.0
// Predicts how the camera moves: as fast as it just did (ORB-SLAM, T-RO 2015, section V-B). It works by stamps, so that
// frames may be left out. Odometry or an inertial sensor would predict here instead.
#pragma once

#include <optional>

#include "covis/core/time.h"
#include "covis/geometry/se3.h"
#include "covis/tracking/usual_interval.h"

namespace covis {

class MotionModel {
 public:
  // Forgets the motion.
  void reset() { motion_.reset(); }
  // The camera moved by T_21 (first camera to second) in this time, which is not zero; it is negative where frames are
  // followed backward. A motion in a burst is taken together with the one before.
  void observe(const SE3& T_21, Timestamp elapsed);
  // Lengths of the map grew by this factor.
  void rescale(double growth);
  // T_21 of the camera after this time. Without a motion, or after a pause, there is no prediction.
  std::optional<SE3> predict(Timestamp elapsed) const;
  // The turn of the rays a second as a rotation vector, radians.
  static Eigen::Vector3d turn_rate(const SE3& T_21, Timestamp elapsed);
  // True when frames did not come for so long that nothing can be predicted from the motion before.
  bool is_pause(Timestamp elapsed) const;
  // The motion to the same camera centre as T_21's, but with another rotation.
  static SE3 turned(const SE3& T_21, const Eigen::Matrix3d& R_21) { return {R_21, -(R_21 * T_21.inverse().t())}; }

 private:
  struct Motion {
    SE3 T_21;
    Timestamp elapsed;
  };
  std::optional<Motion> motion_;
  UsualInterval usual_;
};

}  // namespace covis
