// SPDX-License-Identifier: Apache-2.0
// The latest frames that got no pose: those before a monocular map began, and those while the camera was lost. Where
// the camera is found again, or the map has begun, they can be located from there, backward in time (backtrack.h).
#pragma once

#include <vector>

#include "covis/map/map_requests.h"
#include "covis/tracking/tracked_frame.h"

namespace covis {

class Backlog {
 public:
  Backlog();
  // Keeps a frame; the oldest goes when there are too many.
  void keep(const TrackedFrame& frame);
  // The frame after those kept is near this key frame.
  void found_at(KeyFrameId key_frame);
  // The place where the camera was found does not hold.
  void lost() {
    for (UnlocatedFrame& frame : frames_) frame.near = {};
  }
  // Takes the frames after which the camera was found, newest first.
  std::vector<UnlocatedFrame> take();

 private:
  std::vector<UnlocatedFrame> frames_;  // oldest first
};

}  // namespace covis
