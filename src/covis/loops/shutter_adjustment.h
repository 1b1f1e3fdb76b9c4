// SPDX-License-Identifier: Apache-2.0
// A map whose camera proves to have another rolling shutter: the turn between rows is taken out of the keypoints of its
// key frames, as far as it is known, and each submap is adjusted to them.
#pragma once

#include <memory>
#include <vector>

#include "covis/features/features.h"
#include "covis/loops/background_adjustment.h"
#include "covis/mapping/map_problem.h"

namespace covis {

class ShutterAdjustment : public AdjustmentJob {
 public:
  // row_time: Pinhole::row_time. Null when there is nothing to adjust.
  static std::unique_ptr<ShutterAdjustment> of(const Map& map, double row_time);

  AdjustmentKind kind() const override { return AdjustmentKind::camera; }
  bool run(const std::atomic<bool>& interrupt) override;
  std::optional<KeyFrameMoves> apply(SharedMap& map) const override;

 private:
  // The key frames' features and, for each observation, the one of them.
  struct Part {
    MapProblem submap;
    std::vector<FeaturesPtr> features;
    std::vector<uint32_t> feature;

    Part(const Map& map, MapProblem of_submap);
    // Puts the observations where they are for the camera. False: the adjustment failed.
    bool adjust(const Pinhole& camera, const std::atomic<bool>& interrupt);
  };

  explicit ShutterAdjustment(double row_time) : row_time_(row_time) {}

  std::vector<Part> parts_;
  const double row_time_;
};

}  // namespace covis
