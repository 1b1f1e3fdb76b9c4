// SPDX-License-Identifier: Apache-2.0
// A map whose camera proves to have another rolling shutter: the turn between rows is taken out of the keypoints of its
// key frames, as far as it is known, and the map is adjusted to them.
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
  static std::unique_ptr<ShutterAdjustment> of(const Map& map, KeyFrameId key_frame, double row_time);

  AdjustmentKind kind() const override { return AdjustmentKind::camera; }
  bool run(const std::atomic<bool>& interrupt) override;
  bool apply(SharedMap& map) const override;

 private:
  ShutterAdjustment(MapProblem submap, double row_time) : submap_(std::move(submap)), row_time_(row_time) {}

  MapProblem submap_;
  const double row_time_;
  std::vector<FeaturesPtr> features_;  // those of key frames
  std::vector<uint32_t> feature_;      // one for each observation
};

}  // namespace covis
