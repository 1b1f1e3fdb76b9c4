// SPDX-License-Identifier: Apache-2.0
#include "covis/storage/map_anchors.h"

#include <algorithm>

#include "covis/map/anchors.h"
#include "covis/storage/map_file_format.h"

namespace covis::storage {

bool has_anchors(const MapState& map) {
  return std::any_of(map.key_frames.begin(), map.key_frames.end(),
                     [](const KeyFrameState& k) { return !k.features->anchor.empty(); });
}

std::string anchor_bytes(const MapState& map) {
  FieldWriter fields;
  for (const KeyFrameState& k : map.key_frames) {
    const AlignedVector<uint64_t>& anchor = k.features->anchor;
    fields(static_cast<uint8_t>(!anchor.empty()));
    if (!anchor.empty()) fields.array(anchor.data(), anchor.size());
  }
  return fields.take();
}

std::string read_anchors(std::string_view bytes, const std::vector<uint32_t>& features, uint32_t next_serial,
                         std::vector<AlignedVector<uint64_t>>& anchors) {
  FieldReader fields(bytes);
  for (const uint32_t count : features) {
    AlignedVector<uint64_t>& anchor = anchors.emplace_back();
    uint8_t has = 0;
    fields(has);
    if (has > 1) return "its section of anchors says neither yes nor no for a key frame";
    if (has == 0) continue;
    fields.sized_list(anchor, count);
    if (std::any_of(anchor.begin(), anchor.end(), [&](uint64_t a) { return a >> kAnchorFeatureBits > next_serial; }))
      return "a feature was aligned with a key frame of a serial that is not given yet";
  }
  return fields.whole() ? "" : kNotRightLength;
}

}  // namespace covis::storage
