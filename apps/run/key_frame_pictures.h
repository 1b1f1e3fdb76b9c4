// SPDX-License-Identifier: Apache-2.0
// Reads images of the recording again: for the colours of the key frames, in a thread of its own beside tracking, and
// for the key frames' images, kept beside the map.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <filesystem>
#include <mutex>
#include <set>
#include <thread>

#include "covis/exchange/kept_images.h"
#include "covis/io/sequence.h"
#include "covis/map/map_state.h"
#include "covis/slam/system.h"

namespace covis::app {

class KeyFrameColouring {
 public:
  KeyFrameColouring(io::Sequence& sequence, System& system);
  // Ends without finish() where the run ends by an error.
  ~KeyFrameColouring();

  // There may be a new key frame.
  void wake();
  // Waits until every key frame has its colours. Call it once, after System::finish().
  void finish();

 private:
  void run(const std::stop_token& stop);
  void fill();

  io::Sequence& sequence_;
  System& system_;
  std::mutex mutex_;  // guards `woken_`
  std::condition_variable_any changed_;
  bool woken_ = false;
  std::set<int64_t> without_;  // frames whose images have no colours, or can't be read again
  std::jthread thread_;        // last member: it uses the others
};

// Writes the images of the key frames that have serials of `first_own` and above (those of this recording), as they
// were recorded, where possible by copying their files. `earlier_map`: the file of the map that has the others, whose
// images are copied if they were kept; may be empty. Images that `kept` had of other key frames are removed. An image
// that can't be read is left out with a warning.
Result<void> keep_images(io::Sequence& sequence, const MapState& map, uint32_t first_own,
                         const std::filesystem::path& earlier_map, const exchange::KeptImages& kept);

}  // namespace covis::app
