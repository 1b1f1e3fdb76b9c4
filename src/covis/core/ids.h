// SPDX-License-Identifier: Apache-2.0
// Handles of the objects that the map owns. A handle is a slot and that slot's generation. Erasing an object increases
// the generation of its slot, so the map detects stale handles and never dereferences them (architecture.md, decision
// 1).
#pragma once

#include <compare>
#include <cstdint>
#include <functional>

namespace covis {

template <class Tag>
struct Id {
  static constexpr uint32_t kNoSlot = 0xffffffffu;

  uint32_t slot = kNoSlot;
  uint32_t generation = 0;

  constexpr bool valid() const { return slot != kNoSlot; }
  friend constexpr auto operator<=>(const Id&, const Id&) = default;
};

// The handle as one number, never 0 for a valid one and never that of another thing.
template <class Tag>
constexpr uint64_t id_number(const Id<Tag>& id) {
  return id.valid() ? (uint64_t{id.generation} << 32 | id.slot) + 1 : 0;
}

using KeyFrameId = Id<struct KeyFrameTag>;
using MapPointId = Id<struct MapPointTag>;

}  // namespace covis

template <class Tag>
struct std::hash<covis::Id<Tag>> {
  size_t operator()(const covis::Id<Tag>& id) const noexcept {
    return std::hash<uint64_t>{}((uint64_t{id.generation} << 32) | id.slot);
  }
};
