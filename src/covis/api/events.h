// SPDX-License-Identifier: Apache-2.0
// Tells what happened from what tracking and mapping report.
#pragma once

#include <cstdint>
#include <vector>

#include "covis/covis.h"
#include "covis/slam/system.h"

namespace covis {

class EventTeller {
 public:
  // `state`: that before the first frame.
  explicit EventTeller(TrackingState state) : state_(state) {}

  // The events of a frame in their order: a submap that begins, then mapping's, then the camera's.
  std::vector<Event> of_frame(int64_t stamp, const FrameReport& report, const SharedMap& map);
  // Mapping's events.
  static std::vector<Event> of_mapping(const std::vector<MappingReport>& reports, const SharedMap& map);
  // Those of mapping that ended after the frame of the stamp, and the warnings that came with it.
  std::vector<Event> of_end(int64_t stamp, const std::vector<MappingReport>& reports,
                            const std::vector<SensorWarning>& warnings, const SharedMap& map);

 private:
  // The camera's submap may have been joined to another one.
  void follow(const std::vector<Event>& joined);

  TrackingState state_;
  uint32_t submap_ = 0;  // of the last frame with a pose
};

}  // namespace covis
