// SPDX-License-Identifier: Apache-2.0
#include "covis/slam/key_frame_colours.h"

#include <algorithm>
#include <utility>
#include <vector>

namespace covis {
namespace {

struct Wanted {
  KeyFrameId key_frame;
  int64_t frame = 0;
  FeaturesPtr features;
};

std::vector<Wanted> without_colours(const Map& map, uint32_t first_serial) {
  std::vector<Wanted> wanted;
  map.for_each_key_frame([&](KeyFrameId id, const KeyFrame& key_frame) {
    if (key_frame.serial >= first_serial && !key_frame.colours)
      wanted.push_back({id, key_frame.frame, key_frame.features});
  });
  // A video is read once more in this order.
  std::sort(wanted.begin(), wanted.end(), [](const Wanted& a, const Wanted& b) { return a.frame < b.frame; });
  return wanted;
}

}  // namespace

void KeyFrameColours::map_loaded(uint32_t first_serial) { first_serial_ = first_serial; }

size_t KeyFrameColours::fill(int width, int height, const ColourSource& image_of) {
  const std::lock_guard lock(filling_);
  size_t filled = 0;
  const std::vector<Wanted> all = without_colours(*map_.read(), first_serial_);
  for (const Wanted& wanted : all) {
    const auto image = image_of(wanted.frame);
    if (!image || image->width != width || image->height != height) continue;
    ColoursPtr colours = colours_at(*wanted.features, *image);
    filled += map_.write()->set_colours(wanted.key_frame, std::move(colours));
  }
  return filled;
}

}  // namespace covis
