// SPDX-License-Identifier: Apache-2.0
#include "covis/loops/claims_around.h"

#include <algorithm>

#include "covis/core/reserve.h"

namespace covis {
namespace {

std::pair<uint32_t, uint32_t> submaps_of(const Map& map, KeyFrameId a, KeyFrameId b) {
  return std::minmax({map.at(a).submap, map.at(b).submap});
}

}  // namespace

void ClaimsAround::add(const Map& map, KeyFrameId a, KeyFrameId b) {
  at_slot(others_, a.slot).push_back(b);
  at_slot(others_, b.slot).push_back(a);
  ++between_[submaps_of(map, a, b)];
}

bool ClaimsAround::suffice(const Map& map, KeyFrameId a, KeyFrameId b) const {
  const auto near_b = [&](KeyFrameId id) { return id == b || map.weight(id, b) >= kCovisibilityThreshold; };
  const auto count = [&](KeyFrameId id) { return std::count_if(others_of(id).begin(), others_of(id).end(), near_b); };
  auto found = count(a);
  for (const Neighbour& n : map.neighbours(a)) found += count(n.key_frame);
  const auto all = between_.find(submaps_of(map, a, b));
  return found >= (all != between_.end() && all->second >= kManyClaims ? kTiesOfAPlace : kClaimsOfAPlace);
}

std::span<const KeyFrameId> ClaimsAround::others_of(KeyFrameId id) const {
  return id.slot < others_.size() ? std::span<const KeyFrameId>(others_[id.slot]) : std::span<const KeyFrameId>();
}

}  // namespace covis
