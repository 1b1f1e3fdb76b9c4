// SPDX-License-Identifier: Apache-2.0
// The latest frames without a pose: those before a monocular map began, those while the camera was lost, and those
// whose poses were taken back. Where the camera was found, or the map has begun, they can be located from there,
// backward in time (backtrack.h), as soon as that place is sure.
//
//   keep ──▶ found_at ──▶ settle ──▶ take           lost() undoes found_at(), but nothing that settled
//   keep_for_now ──────▶ settle: forgotten          lost(): they wait like those that were kept
#pragma once

#include <vector>

#include "covis/map/map_requests.h"
#include "covis/tracking/tracked_frame.h"

namespace covis {

// A frame that waits may have a pose meanwhile; who locates it drops the second one.
class Backlog {
 public:
  Backlog();
  // Keeps a frame; the oldest goes when there are too many.
  void keep(const TrackedFrame& frame);
  // Keeps a frame with a pose that may be taken back.
  void keep_for_now(const TrackedFrame& frame);
  // The camera is near this key frame, and was somewhere on the way to it with the frames kept since it was lost.
  void found_at(KeyFrameId key_frame);
  // The place where it was found is sure, and so are the poses since.
  void settle();
  // The camera is lost, or the place proved wrong.
  void lost();
  // Takes the frames whose places are settled, newest first.
  std::vector<UnlocatedFrame> take();
  // Takes those, and copies the ones that were found before them, newest first.
  std::vector<UnlocatedFrame> take_with_found();

 private:
  // Each oldest first, and all of one before those of the next.
  std::vector<UnlocatedFrame> settled_;
  std::vector<UnlocatedFrame> frames_;
  std::vector<UnlocatedFrame> for_now_;
};

}  // namespace covis
