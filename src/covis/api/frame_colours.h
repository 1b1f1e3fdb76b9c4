// SPDX-License-Identifier: Apache-2.0
// Uses the colour images of a program's frames: makes a grey image where it gives none, and gives its key frames their
// colours. For the tracking thread alone.
#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "covis/api/rectifier.h"
#include "covis/core/image.h"
#include "covis/slam/system.h"
#include "covis/types.h"

namespace covis {

// The grey values of a colour image (ITU-R BT.601: 0.299 R + 0.587 G + 0.114 B).
void make_grey(const ColourImage& image, ImageU8& grey);

class FrameColours {
 public:
  // The grey image of a colour image, until the next call.
  ImageView<const uint8_t> grey(const ColourImage& image);
  // Keeps a copy of the image of a frame that may become a key frame; `rectifier`: that of the frame's pair, or null.
  void keep(int64_t frame, const ColourImage& image, const Rectifier* rectifier);
  // Gives the key frames of the images kept their colours. Images of frames that have become key frames, or are older
  // than one that has, are let go.
  void give(System& system);

 private:
  struct Kept {
    int64_t frame = 0;
    ColourOrder order = ColourOrder::rgb;
    int width = 0, height = 0;
    std::vector<uint8_t> bytes;  // without gaps between rows
    ColourImage view() const { return {bytes.data(), width, height, 3 * static_cast<ptrdiff_t>(width), order}; }
  };
  static constexpr size_t kMost = 8;  // images that wait until mapping has made their key frames

  ImageU8 grey_;
  std::deque<Kept> kept_;  // by rising frame
};

}  // namespace covis
