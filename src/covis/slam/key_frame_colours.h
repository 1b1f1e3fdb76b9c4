// SPDX-License-Identifier: Apache-2.0
// Gives key frames of this run their colours, from the colour images of their frames. Tracking does not wait for it:
// only the frames that became key frames are looked at, and when they are is up to the caller.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <mutex>
#include <optional>

#include "covis/map/shared_map.h"

namespace covis {

// The colour image of a frame, valid until the next call; nothing when there is none.
using ColourSource = std::function<std::optional<ColourImage>(int64_t frame)>;

class KeyFrameColours {
 public:
  explicit KeyFrameColours(SharedMap& map) : map_(map) {}

  // Key frames of lower serials came with a map: their frames are of another recording.
  void map_loaded(uint32_t first_serial);
  // Gives each key frame without colours those of the image that `image_of` has for its frame. An image of another
  // size than `width` x `height` is passed over. Returns how many key frames got theirs. One call at a time; beside it
  // anything may go on.
  size_t fill(int width, int height, const ColourSource& image_of);

 private:
  SharedMap& map_;
  std::mutex filling_;  // held while colours are filled in, so that one call at a time does so
  // Atomic and not under the mutex: `fill` locks the map while it holds that, and a map may be loaded under its lock.
  std::atomic<uint32_t> first_serial_{0};
};

}  // namespace covis
