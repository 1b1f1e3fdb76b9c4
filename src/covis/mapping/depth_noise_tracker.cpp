// SPDX-License-Identifier: Apache-2.0
#include "covis/mapping/depth_noise_tracker.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "covis/core/log.h"
#include "covis/optimization/depth_noise_estimation.h"

namespace covis {

void DepthNoiseTracker::learn(SharedMap& shared, const BundleProblem& problem) {
  constexpr double kLeastScale = 1.0 / 16, kGreatestScale = 4;
  constexpr double kLeastGain = 0.05;
  constexpr double kWorthTelling = 1.5;
  const std::optional<double> factor = depth_noise_factor(problem);
  if (!factor) return;
  Pinhole camera = shared.read()->camera();
  // The map may have begun with what another run found, and its depths may have been looked up anew.
  const DepthNoise known = left_.value_or(DepthNoise::kinect());
  if (known != camera.depth_noise && camera.depth_noise.b > 0) scale_ *= camera.depth_noise.b / known.b;
  const double gain = std::max(kLeastGain, 1.0 / (++problems_ + 1));
  const double scale = std::clamp(scale_ * std::pow(*factor, gain), kLeastScale, kGreatestScale);
  camera.depth_noise = camera.depth_noise.scaled(scale / scale_);
  scale_ = scale;
  left_ = camera.depth_noise;
  shared.write()->set_camera(camera);
  if (std::abs(std::log(scale_ / logged_)) < std::log(kWorthTelling)) return;
  logged_ = scale_;
  log(LogLevel::info, "depth noise estimated: sigma = " + std::to_string(camera.depth_noise.a * 1000) + " mm + " +
                          std::to_string(camera.depth_noise.b * 1000) + " mm a square metre");
}

}  // namespace covis
