// SPDX-License-Identifier: Apache-2.0
#include "covis/storage/map_colours.h"

#include <algorithm>
#include <memory>
#include <utility>

#include "covis/storage/map_file_format.h"

namespace covis::storage {

bool has_colours(const MapState& map) {
  return std::any_of(map.key_frames.begin(), map.key_frames.end(),
                     [](const KeyFrameState& k) { return k.colours != nullptr; });
}

std::string colour_bytes(const MapState& map) {
  FieldWriter fields;
  for (const KeyFrameState& k : map.key_frames) {
    fields(static_cast<uint8_t>(k.colours != nullptr));
    if (k.colours) fields.array(k.colours->data(), k.colours->size());
  }
  return fields.take();
}

std::string take_colours(std::string_view bytes, std::vector<KeyFrameState>& key_frames) {
  FieldReader fields(bytes);
  for (KeyFrameState& k : key_frames) {
    uint8_t has = 0;
    fields(has);
    if (has > 1) return "its section of colours says neither yes nor no for a key frame";
    if (has == 0) continue;
    std::vector<Colour> colours;
    fields.sized_list(colours, k.points.size());
    k.colours = std::make_shared<const std::vector<Colour>>(std::move(colours));
  }
  return fields.whole() ? "" : kNotRightLength;
}

}  // namespace covis::storage
