// SPDX-License-Identifier: Apache-2.0
#include "covis/map/map_memory.h"

namespace covis {
namespace {

template <class... Arrays>
size_t bytes_of(const Arrays&... arrays) {
  return ((arrays.size() * sizeof(typename Arrays::value_type)) + ...);
}

size_t memory_of(const Features& f) {
  return sizeof(f) + (f.patches ? f.patches->bytes() : 0) + (f.kept_depth ? f.kept_depth->bytes() : 0) +
         bytes_of(f.x, f.y, f.raw_x, f.raw_y, f.angle, f.u_right, f.depth, f.level, f.descriptor, f.anchor,
                  f.grid.offsets, f.grid.indices);
}

size_t memory_of(const KeyFrame& key_frame) {
  size_t bytes = sizeof(key_frame) + memory_of(*key_frame.features) +
                 bytes_of(key_frame.points, key_frame.shared, key_frame.children, key_frame.loop_edges);
  if (key_frame.words) {
    constexpr size_t kInDatabase = sizeof(uint32_t);  // the key frame's entry in a word's list
    bytes += key_frame.words->words.size() * (sizeof(WordWeight) + kInDatabase);
  }
  return bytes;
}

}  // namespace

size_t memory_of(const Map& map) {
  size_t bytes = 0;
  map.for_each_key_frame([&](KeyFrameId, const KeyFrame& key_frame) { bytes += memory_of(key_frame); });
  map.for_each_point([&](MapPointId, const MapPoint& point) { bytes += sizeof(point) + bytes_of(point.observations); });
  return bytes;
}

}  // namespace covis
