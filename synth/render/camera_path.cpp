// SPDX-License-Identifier: Apache-2.0
#include "synth/render/camera_path.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "covis/core/random.h"

namespace covis::synth {
namespace {
constexpr int kWaves = 3;  // number of sines per channel
}

SE3 CameraPose::T_wc() const {
  const Eigen::Vector3d forward(std::cos(pitch) * std::cos(heading), std::cos(pitch) * std::sin(heading),
                                std::sin(pitch));
  const Eigen::Vector3d right(std::sin(heading), -std::cos(heading), 0);
  const Eigen::Vector3d down = forward.cross(right);
  Eigen::Matrix3d R;
  R.col(0) = std::cos(roll) * right + std::sin(roll) * down;
  R.col(1) = std::cos(roll) * down - std::sin(roll) * right;
  R.col(2) = forward;
  return {R, position};
}

CameraPath::CameraPath(std::vector<CameraPose> control, double interval, int turns, const Sway& sway, uint64_t seed)
    : control_(std::move(control)), interval_(interval), turns_(turns) {
  Random random(seed);
  for (int channel = 0; channel < 6; ++channel) {
    for (int i = 0; i < kWaves; ++i) {
      const double frequency =
          sway.slowest * std::pow(sway.fastest / sway.slowest, (i + random.uniform(0.2, 0.8)) / kWaves);
      // Amplitude falls with frequency, so that each wave contributes about the same speed.
      const double amplitude = (channel < 3 ? sway.metres : sway.radians) * sway.slowest / frequency;
      waves_.push_back({frequency, random.uniform(0, 2 * std::numbers::pi), amplitude});
    }
  }
}

CameraPath::CameraPath(std::vector<CameraPose> control, double interval, const Sway& sway, uint64_t seed)
    : CameraPath(std::move(control), interval, 0, sway, seed) {
  open_ = true;
}

CameraPose CameraPath::control(int64_t i) const {
  const int64_t n = static_cast<int64_t>(control_.size());
  if (open_) return control_[static_cast<size_t>(std::clamp<int64_t>(i + 1, 0, n - 1))];
  const int64_t round = i >= 0 ? i / n : -((n - 1 - i) / n);
  CameraPose pose = control_[static_cast<size_t>(i - round * n)];
  pose.heading += 2 * std::numbers::pi * turns_ * static_cast<double>(round);
  return pose;
}

double CameraPath::wave(int channel, double seconds) const {
  double sum = 0;
  for (int i = 0; i < kWaves; ++i) {
    const Wave& w = waves_[static_cast<size_t>(channel * kWaves + i)];
    sum += w.amplitude * std::sin(2 * std::numbers::pi * w.frequency * seconds + w.phase);
  }
  return sum;
}

CameraPose CameraPath::at(double seconds) const {
  const double s = seconds / interval_;
  const int64_t i = static_cast<int64_t>(std::floor(s));
  const double t = s - static_cast<double>(i), t2 = t * t, t3 = t2 * t;
  const double basis[4] = {(1 - 3 * t + 3 * t2 - t3) / 6, (4 - 6 * t2 + 3 * t3) / 6, (1 + 3 * t + 3 * t2 - 3 * t3) / 6,
                           t3 / 6};
  CameraPose pose;
  for (int k = 0; k < 4; ++k) {
    const CameraPose c = control(i - 1 + k);
    pose.position += basis[k] * c.position;
    pose.heading += basis[k] * c.heading;
    pose.pitch += basis[k] * c.pitch;
    pose.roll += basis[k] * c.roll;
  }
  pose.position += Eigen::Vector3d(wave(0, seconds), wave(1, seconds), wave(2, seconds));
  pose.heading += wave(3, seconds);
  pose.pitch += wave(4, seconds);
  pose.roll += wave(5, seconds);
  return pose;
}

}  // namespace covis::synth
