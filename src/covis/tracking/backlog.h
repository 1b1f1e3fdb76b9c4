// SPDX-License-Identifier: Apache-2.0
// The latest frames that got no pose: those before a monocular map began, those while the camera was lost, and those
// whose poses were taken back. Where the camera is found again, or the map has begun, they can be located from there,
// backward in time (backtrack.h).
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
  // Keeps a frame with a pose that may be taken back, until the next call of settle() or lost().
  void keep_for_now(const TrackedFrame& frame);
  // Poses will not be taken back any more.
  void settle() { for_now_.clear(); }
  // The frame after those kept is near this key frame.
  void found_at(KeyFrameId key_frame);
  // The camera is lost: the place where it was found may not hold.
  void lost();
  // Takes the frames after which the camera was found, newest first.
  std::vector<UnlocatedFrame> take();

 private:
  std::vector<UnlocatedFrame> frames_, for_now_;  // oldest first, all of the latter after the former
};

}  // namespace covis
