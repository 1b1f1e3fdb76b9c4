// SPDX-License-Identifier: Apache-2.0
// How the camera is expected to move: as fast as it just did (ORB-SLAM, T-RO 2015, section V-B). Works by stamps, so
// that frames may be left out. This is where odometry or an inertial sensor would predict instead.
#pragma once

#include <optional>

#include "covis/core/time.h"
#include "covis/geometry/se3.h"

namespace covis {

class MotionModel {
 public:
  // Nothing is known of the motion.
  void reset() { motion_.reset(); }
  // The camera moved by T_21 (first camera to second) in this time, which is positive.
  void observe(const SE3& T_21, Timestamp elapsed);
  // Lengths of the map grew by this factor.
  void rescale(double growth);
  // T_21 of the camera after this time; nothing without a motion, or after a pause.
  std::optional<SE3> predict(Timestamp elapsed) const;

 private:
  struct Motion {
    SE3 T_21;
    Timestamp elapsed;
  };
  std::optional<Motion> motion_;
};

}  // namespace covis
