// SPDX-License-Identifier: Apache-2.0
#include "covis/map/map_union.h"

#include <algorithm>
#include <iterator>
#include <memory>
#include <string>
#include <utility>

#include "covis/map/anchors.h"

namespace covis {
namespace {

bool fits(size_t a, size_t b) { return a + b < MapState::kNone; }

// Anchors name key frames by their serials, which are shifted by `by`.
FeaturesPtr with_anchors_shifted(const FeaturesPtr& features, uint32_t by) {
  if (features->anchor.empty() || by == 0) return features;
  auto made = std::make_shared<Features>(*features);
  for (uint64_t& anchor : made->anchor) anchor += anchor > 0 ? uint64_t{by} << kAnchorFeatureBits : 0;
  return made;
}

}  // namespace

Result<void> append_map(MapState& map, MapState other) {
  if (!fits(map.key_frames.size(), other.key_frames.size()) || !fits(map.points.size(), other.points.size()) ||
      !fits(map.next_serial, other.next_serial)) {
    return fail("together the maps have more key frames or points than one map can: " +
                std::to_string(map.key_frames.size() + other.key_frames.size()) + " and " +
                std::to_string(map.points.size() + other.points.size()));
  }
  const auto frames = static_cast<uint32_t>(map.key_frames.size());
  const auto points = static_cast<uint32_t>(map.points.size());
  const auto shift = [](uint32_t& index, uint32_t by) {
    if (index != MapState::kNone) index += by;
  };
  for (KeyFrameState& k : other.key_frames) {
    k.serial += map.next_serial;
    k.features = with_anchors_shifted(k.features, map.next_serial);
    shift(k.parent, frames);
    for (uint32_t& point : k.points) shift(point, points);
    for (uint32_t& edge : k.loop_edges) edge += frames;
  }
  for (MapPointState& point : other.points) point.reference += frames;
  if (map.root == MapState::kNone) {
    map.root = other.root;
    shift(map.root, frames);
  }
  map.next_serial += other.next_serial;
  std::move(other.key_frames.begin(), other.key_frames.end(), std::back_inserter(map.key_frames));
  std::move(other.points.begin(), other.points.end(), std::back_inserter(map.points));
  return {};
}

}  // namespace covis
