// SPDX-License-Identifier: Apache-2.0
// Reads images of the recording again: for the colours of the key frames, in a thread of its own beside tracking, and
// for the key frames' images, kept beside the map.
#pragma once

#include <condition_variable>
#include <filesystem>
#include <mutex>
#include <thread>

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
  bool grey_ = false;    // an image had no colours: no other has any
  std::jthread thread_;  // last member: it uses the others
};

// The folder of a map's key frames' images: FILE.images. Each is called by the key frame's serial, in six digits or
// more.
std::filesystem::path image_folder(const std::filesystem::path& map_file);

// Writes the images of the key frames that have serials of `first_own` and above (those of this recording), as they
// were recorded, where possible by copying their files. `earlier`: the folder with the images of the others, may be
// empty. Images of other key frames that are in `folder` are removed. An image that can't be read is left out with a
// warning.
Result<void> keep_images(io::Sequence& sequence, const MapState& map, uint32_t first_own,
                         const std::filesystem::path& earlier, const std::filesystem::path& folder);

}  // namespace covis::app
