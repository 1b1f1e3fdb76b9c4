// SPDX-License-Identifier: Apache-2.0
// Images for the viewer: small JPEGs, and a store of those of key frames that is bounded.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "apps/view/rows.h"
#include "covis/core/error.h"
#include "covis/core/image.h"
#include "covis/io/images.h"

namespace covis::view {

// A copy of a frame's image, to be encoded by another thread.
struct RawImage {
  RawImage(int32_t frame_index, ImageView<const uint8_t> image);
  int32_t frame = 0;
  ImageU8 grey;
  std::vector<KeypointRow> keypoints;
};

// Returns a JPEG that is at most `width` pixels wide; nothing for an empty image. The error says why there is none: the
// plug-in that encodes is missing, say.
Result<std::string> jpeg_of(ImageView<const uint8_t> image, int width);
Result<std::string> jpeg_of(const io::Picture& picture, int width);

// By frame. Beyond its limit the oldest go.
class ImageStore {
 public:
  explicit ImageStore(size_t most_bytes = 64 << 20) : most_bytes_(most_bytes) {}
  void put(int32_t frame, std::string jpeg);
  std::optional<std::string> get(int32_t frame) const;

 private:
  const size_t most_bytes_;
  size_t bytes_ = 0;
  std::map<int32_t, std::string> images_;
};

}  // namespace covis::view
