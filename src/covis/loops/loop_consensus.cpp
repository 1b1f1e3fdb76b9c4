// SPDX-License-Identifier: Apache-2.0
#include "covis/loops/loop_consensus.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace covis {
namespace {

// More than half of the points of the smaller claim are in the other too: both saw the same.
bool same_points(const std::vector<MapPointId>& a, const std::vector<MapPointId>& b) {
  size_t shared = 0;
  for (const MapPointId& id : a) shared += std::binary_search(b.begin(), b.end(), id);
  return 2 * shared > std::min(a.size(), b.size());
}

}  // namespace

bool opinions_agree(const Sim3& difference, double way, double depth) {
  constexpr double kDrift = 0.1, kDepthShare = 0.1, kRotation = 5 * std::numbers::pi / 180, kScale = 1.2;
  return so3_log(difference.R()).norm() <= kRotation && std::abs(std::log(difference.scale())) <= std::log(kScale) &&
         difference.t().norm() <= kDrift * way + kDepthShare * depth;
}

Sim3 LoopConsensus::Claim::correction(const Map& map) const {
  return (S_here_there * Sim3(map.at(there).T_cw)).inverse() * Sim3(map.at(here).T_cw);
}

bool LoopConsensus::agree(const Map& map, const Claim& earlier, const Claim& now, double depth) {
  constexpr uint32_t kSoon = 10;  // key frames
  const KeyFrame *before = map.find(earlier.here), *place_before = map.find(earlier.there);
  if (!before || !place_before) return false;
  const KeyFrame &here = map.at(now.here), &place = map.at(now.there);
  if (before->submap != here.submap || place_before->submap != place.submap || earlier.here == now.here) return false;
  if (before->scale != earlier.scale_here || place_before->scale != earlier.scale_there) return false;
  if (now.by == By::any_points) {
    if (here.serial - before->serial > kSoon) return false;
  } else if (earlier.by != now.by || earlier.moves != now.moves || same_points(earlier.points, now.points)) {
    return false;
  }
  const Sim3 T_cw(here.T_cw);
  const Sim3 difference = T_cw * now.correction(map).inverse() * earlier.correction(map) * T_cw.inverse();
  return opinions_agree(difference, travel_between(map, here.submap, before->serial, here.serial).length, depth);
}

bool LoopConsensus::confirms(const Map& map, KeyFrameId current, const Loop& claim, By by) {
  constexpr size_t kKept = 20;
  if (claim.matches.empty()) return false;
  const KeyFrame &here = map.at(current), *place = map.find(claim.place.key_frame);
  if (!place) return false;
  Claim now{current,
            claim.place.key_frame,
            claim.S_cw * Sim3(claim.place.T_cw).inverse(),
            here.scale,
            place->scale,
            map.moves(),
            {},
            by};
  for (const auto& [feature, point] : claim.matches) now.points.push_back(point);
  std::sort(now.points.begin(), now.points.end());
  const double depth = claim.S_cw.scale() * median_depth(claim);  // in the unit of the current key frame's map
  const bool confirmed =
      std::any_of(claims_.begin(), claims_.end(), [&](const Claim& c) { return agree(map, c, now, depth); });
  if (claims_.size() == kKept) claims_.erase(claims_.begin());
  claims_.push_back(std::move(now));
  return confirmed;
}

}  // namespace covis
