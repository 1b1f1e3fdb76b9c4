// SPDX-License-Identifier: Apache-2.0
#include "covis/mapping/map_limit.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <unordered_set>
#include <vector>

#include "covis/map/map_memory.h"
#include "covis/mapping/map_thinning.h"

namespace covis {
namespace {

constexpr uint32_t kEvery = 8;    // key frames between two looks
constexpr uint32_t kRecent = 50;  // newest key frames that stay
constexpr double kAtATime = 64;   // key frames erased at a look: a map that is far too large shrinks step by step

// Returns the key frames to erase; nullopt: the map is within its bound.
std::optional<std::vector<KeyFrameId>> choose(const Map& map, KeyFrameId current, size_t most) {
  const size_t bytes = memory_of(map);
  if (bytes <= most) return std::nullopt;
  const auto all = static_cast<double>(map.key_frame_count());
  const double left = std::floor(all * 0.95 * static_cast<double>(most) / static_cast<double>(bytes));
  std::unordered_set<KeyFrameId> needed{current};
  for (const Neighbour& n : map.at(current).shared) needed.insert(n.key_frame);
  const uint32_t newest = map.at(current).serial;
  return expendable_key_frames(map, static_cast<size_t>(std::min(all - left, kAtATime)), [&](KeyFrameId id) {
    return map.at(id).serial + kRecent <= newest && !needed.contains(id);
  });
}

}  // namespace

LimitReport limit_map(SharedMap& shared, KeyFrameId current, size_t most) {
  const auto chosen = [&] {
    const auto map = shared.read();
    return map->at(current).serial % kEvery == 0 ? choose(*map, current, most) : std::nullopt;
  }();
  if (!chosen) return {};
  // Each erasure has a guard of its own, so that readers wait for one at most. Points keep normal and descriptor.
  for (const KeyFrameId& id : *chosen) shared.write()->erase_key_frame(id);
  return {static_cast<int>(chosen->size()), chosen->empty()};
}

}  // namespace covis
