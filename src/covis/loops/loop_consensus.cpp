// SPDX-License-Identifier: Apache-2.0
#include "covis/loops/loop_consensus.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "covis/core/quantile.h"

namespace covis {
namespace {

// More than half of the points of the smaller claim are in the other too: both saw the same.
bool same_points(const std::vector<MapPointId>& a, const std::vector<MapPointId>& b) {
  size_t shared = 0;
  for (const MapPointId& id : a) shared += std::binary_search(b.begin(), b.end(), id);
  return 2 * shared > std::min(a.size(), b.size());
}

// The depth of the points found again, as the current key frame's map has it.
double median_depth(const Loop& loop) {
  std::vector<double> depths;
  for (const auto& [feature, id] : loop.matches)
    depths.push_back(
        (loop.S_cw * loop.place.points.position(static_cast<size_t>(index_of(loop.place.points, id)))).z());
  return quantile(std::move(depths), 0.5);
}

// The difference between two opinions of where a camera is is one that the way between them and the errors of both
// explain. `path` and `depth` are in the unit of the camera.
bool agree(const Sim3& one, const Sim3& other, double path, double depth) {
  constexpr double kDrift = 0.1, kDepthShare = 0.1, kRotation = 5 * std::numbers::pi / 180, kScale = 1.2;
  const Sim3 difference = one * other.inverse();
  return difference.t().norm() <= kDrift * path + kDepthShare * depth && so3_log(difference.R()).norm() <= kRotation &&
         std::abs(std::log(difference.scale())) <= std::log(kScale);
}

}  // namespace

bool LoopConsensus::confirms(const Map& map, KeyFrameId current, const Loop& claim, By by) {
  constexpr size_t kKept = 20;
  if (claim.matches.empty()) return false;
  if (moves_ != map.moves()) claims_.clear();
  moves_ = map.moves();
  const KeyFrame& key_frame = map.at(current);
  Claim now{key_frame.submap, key_frame.serial, claim.S_cw.inverse() * Sim3(key_frame.T_cw), {}};
  for (const auto& [feature, point] : claim.matches) now.points.push_back(point);
  std::sort(now.points.begin(), now.points.end());
  const double depth = median_depth(claim);
  const bool confirmed = std::any_of(claims_.begin(), claims_.end(), [&](const Claim& earlier) {
    return earlier.submap == now.submap && (by == By::any_points || !same_points(earlier.points, now.points)) &&
           agree(claim.S_cw, Sim3(key_frame.T_cw) * earlier.S_there_here.inverse(),
                 path_between(map, now.submap, earlier.serial, now.serial), depth);
  });
  if (claims_.size() == kKept) claims_.erase(claims_.begin());
  claims_.push_back(std::move(now));
  return confirmed;
}

}  // namespace covis
