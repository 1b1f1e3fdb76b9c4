// SPDX-License-Identifier: Apache-2.0
#include "covis/api/frame_colours.h"

#include <algorithm>
#include <cstring>

namespace covis {
namespace {

// Rectifies each channel by itself.
void rectify(const Rectifier& rectifier, int width, int height, std::vector<uint8_t>& bytes) {
  ImageU8 from(width, height), to;
  for (size_t channel = 0; channel < 3; ++channel) {
    for (int y = 0; y < height; ++y) {
      const uint8_t* row = &bytes[3 * static_cast<size_t>(y) * static_cast<size_t>(width) + channel];
      for (int x = 0; x < width; ++x) from.row(y)[x] = row[3 * x];
    }
    rectifier.left(from.view(), to);
    for (int y = 0; y < height; ++y) {
      uint8_t* row = &bytes[3 * static_cast<size_t>(y) * static_cast<size_t>(width) + channel];
      for (int x = 0; x < width; ++x) row[3 * x] = to.row(y)[x];
    }
  }
}

}  // namespace

void make_grey(const ColourImage& image, ImageU8& grey) {
  // In 2^16ths; their sum is 2^16.
  constexpr uint32_t kRed = 19595, kGreen = 38470, kBlue = 7471;
  const uint32_t first = image.order == ColourOrder::rgb ? kRed : kBlue, third = kRed + kBlue - first;
  grey.resize(image.width, image.height);
  for (int y = 0; y < image.height; ++y) {
    const uint8_t* from = image.data + y * image.stride;
    uint8_t* to = grey.row(y);
    for (int x = 0; x < image.width; ++x, from += 3)
      to[x] = static_cast<uint8_t>((first * from[0] + kGreen * from[1] + third * from[2] + (1u << 15)) >> 16);
  }
}

ImageView<const uint8_t> FrameColours::grey(const ColourImage& image) {
  make_grey(image, grey_);
  return grey_.view();
}

void FrameColours::keep(int64_t frame, const ColourImage& image, const Rectifier* rectifier) {
  Kept kept{.frame = frame, .order = image.order, .width = image.width, .height = image.height, .bytes = {}};
  const size_t row = 3 * static_cast<size_t>(image.width);
  kept.bytes.resize(row * static_cast<size_t>(image.height));
  for (int y = 0; y < image.height; ++y)
    std::memcpy(&kept.bytes[row * static_cast<size_t>(y)], image.data + y * image.stride, row);
  if (rectifier) rectify(*rectifier, image.width, image.height, kept.bytes);
  if (kept_.size() == kMost) kept_.pop_front();
  kept_.push_back(std::move(kept));
}

void FrameColours::give(System& system) {
  if (kept_.empty()) return;
  int64_t newest = -1;  // the newest frame whose key frame got its colours
  system.colour_key_frames([&](int64_t frame) -> std::optional<ColourImage> {
    const auto found = std::find_if(kept_.begin(), kept_.end(), [&](const Kept& k) { return k.frame == frame; });
    if (found == kept_.end()) return std::nullopt;
    newest = std::max(newest, frame);
    return found->view();
  });
  while (!kept_.empty() && kept_.front().frame <= newest) kept_.pop_front();
}

}  // namespace covis
