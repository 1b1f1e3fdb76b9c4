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

bool LoopConsensus::confirms(const Map& map, KeyFrameId current, const Loop& claim, By by) {
  constexpr size_t kKept = 20;
  if (claim.matches.empty()) return false;
  if (moves_ != map.moves()) claims_.clear();
  moves_ = map.moves();
  const KeyFrame& key_frame = map.at(current);
  Claim now{key_frame.submap, key_frame.serial, claim.S_cw.inverse() * Sim3(key_frame.T_cw), {}, by};
  for (const auto& [feature, point] : claim.matches) now.points.push_back(point);
  std::sort(now.points.begin(), now.points.end());
  const double depth = claim.S_cw.scale() * median_depth(claim);  // in the unit of the current key frame's map
  const bool confirmed = std::any_of(claims_.begin(), claims_.end(), [&](const Claim& earlier) {
    if (earlier.submap != now.submap || earlier.serial == now.serial) return false;
    if (by == By::other_points && (earlier.by != by || same_points(earlier.points, now.points))) return false;
    const Sim3 difference = claim.S_cw * earlier.S_there_here * Sim3(key_frame.T_cw).inverse();
    return opinions_agree(difference, travel_between(map, now.submap, earlier.serial, now.serial).length, depth);
  });
  if (claims_.size() == kKept) claims_.erase(claims_.begin());
  claims_.push_back(std::move(now));
  return confirmed;
}

}  // namespace covis
