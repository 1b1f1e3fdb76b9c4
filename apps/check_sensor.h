// SPDX-License-Identifier: Apache-2.0
// The view that `covis check` has of a recording's depth: the warnings that a run would give, from samples of
// consecutive frames.
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <vector>

#include "covis/features/frontend.h"
#include "covis/io/sequence.h"
#include "covis/slam/sensor_monitor.h"

namespace covis::app {

class SensorSample {
 public:
  // `frames`: number of frames of the recording; -1: unknown.
  SensorSample(const Camera& camera, Sensor sensor, int64_t frames)
      : camera_(camera), sensor_(sensor), step_(std::max<int64_t>(kLength, frames / kSamples)) {}

  // Takes the frames one by one.
  void add(const io::Frame& frame);
  const std::vector<SensorWarning>& warnings() const { return warnings_; }
  // Depths of the keypoints, metres; nullopt: no frame had any.
  struct Depths {
    double tenth = 0, median = 0, nine_tenths = 0;
  };
  std::optional<Depths> depths() const;

 private:
  static constexpr int64_t kSamples = 4, kLength = 40;  // frames of a sample

  // The state within a sample.
  struct Sample {
    Frontend frontend;
    SensorMonitor monitor;
    MotionDepthCheck check;

    Sample(const Camera& camera, Sensor sensor) : frontend(camera, OrbOptions{}, sensor), monitor(sensor) {}
  };

  const Camera camera_;
  const Sensor sensor_;
  const int64_t step_;  // frames from one sample to the next
  int64_t count_ = 0;
  std::optional<Sample> sample_;
  std::vector<SensorWarning> warnings_;
  std::vector<double> depths_;
};

}  // namespace covis::app
