// SPDX-License-Identifier: Apache-2.0
// Smooth camera motion: a uniform cubic B-spline over control points equally spaced in time (position, heading, pitch,
// roll), twice continuously differentiable, plus the sway of a hand or a car. The path is either a loop that repeats
// for ever, or open: then it begins in motion and comes to rest at its end. Source: Unser, Aldroubi, Eden, "B-spline
// signal processing", 1993 (the uniform cubic basis).
#pragma once

#include <cstdint>
#include <vector>

#include "covis/geometry/se3.h"

namespace covis::synth {

// Camera centre in metres (z up); heading about z from +x and pitch upwards, roll about the viewing direction, radians.
struct CameraPose {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  double heading = 0, pitch = 0, roll = 0;

  SE3 T_wc() const;  // camera frame: x right, y down, z forward
};

// A sum of slow sines: the tremor of a hand or a vehicle.
struct Sway {
  double metres = 0;                    // amplitude of each coordinate
  double radians = 0;                   // amplitude of each angle
  double slowest = 0.3, fastest = 1.6;  // range of the frequencies, Hz
};

class CameraPath {
 public:
  // A closed path. Control points are one `interval` (seconds) apart; the last is followed by the first, whose heading
  // has then grown by `turns` whole turns.
  CameraPath(std::vector<CameraPose> control, double interval, int turns, const Sway& sway, uint64_t seed);
  // An open path, from the second control point to the last but one, near which it comes to rest.
  CameraPath(std::vector<CameraPose> control, double interval, const Sway& sway, uint64_t seed);

  // Duration of one round, or of the way along an open path, seconds.
  double period() const { return interval_ * static_cast<double>(open_ ? control_.size() - 3 : control_.size()); }
  CameraPose at(double seconds) const;

 private:
  struct Wave {
    double frequency, phase, amplitude;
  };
  CameraPose control(int64_t i) const;
  double wave(int channel, double seconds) const;

  std::vector<CameraPose> control_;
  double interval_;
  int turns_;
  bool open_ = false;
  std::vector<Wave> waves_;  // kWaves for each of the six channels
};

}  // namespace covis::synth
