// SPDX-License-Identifier: Apache-2.0
// Which claims that two submaps share a place (join_claims.h) would only repeat others. Measured:
// docs/notes/032-merging-maps.md.
#pragma once

#include <map>
#include <span>
#include <utility>
#include <vector>

#include "covis/map/map.h"

namespace covis {

// Claims between the same surroundings repeat one another: what more than so many would say is known. Where two submaps
// have many claims the question is no more whether they are one, and fewer hold them together at each place.
inline constexpr int kClaimsOfAPlace = 12, kTiesOfAPlace = 6;
inline constexpr int kManyClaims = 100;  // of the same two submaps

// The claims that have been made, by the key frames at both of their ends.
class ClaimsAround {
 public:
  void add(const Map& map, KeyFrameId a, KeyFrameId b);
  // True when one more claim between two key frames would say nothing new: enough are made between one of them or a
  // neighbour of it and the other or a neighbour of that.
  bool suffice(const Map& map, KeyFrameId a, KeyFrameId b) const;

 private:
  std::span<const KeyFrameId> others_of(KeyFrameId id) const;

  std::vector<std::vector<KeyFrameId>> others_;           // by slot: the other ends of its claims
  std::map<std::pair<uint32_t, uint32_t>, int> between_;  // number of claims of two submaps
};

}  // namespace covis
