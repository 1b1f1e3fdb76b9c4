// SPDX-License-Identifier: Apache-2.0
#include "covis/matching/expected_matches.h"

#include <algorithm>

namespace covis {
namespace {

// The nearest view in which a point was seen before, compared with the present one.
enum class Seen { elsewhere, near, here };

Seen seen_before(const MapPoint& point, const Map& map, const Eigen::Vector3d& centre_w) {
  Seen seen = Seen::elsewhere;
  for (const Observation& observation : point.observations) {
    const ViewChange change(point.position_w, centre_w, map.at(observation.key_frame).T_cw.centre());
    if (change.is_here()) return Seen::here;
    if (change.is_near()) seen = Seen::near;
  }
  return seen;
}

}  // namespace

void ExpectedMatches::add(const MapPoint& point, const Map& map, const Eigen::Vector3d& centre_w, bool matched) {
  constexpr uint32_t kKnown = 5;  // frames that had a point in view, for its match ratio to be known
  const Seen seen = seen_before(point, map, centre_w);
  if (seen == Seen::elsewhere) return;
  // A match with a point outside of the local map counts as found, and not as visible.
  const double match_ratio = std::min(1.0, static_cast<double>(point.found) / point.visible);
  const auto count = [&](MatchTally& tally) {
    tally.expected += match_ratio;
    tally.found += matched;
  };
  if (seen == Seen::here && point.visible >= kKnown) count(from_here);
  if (point.visible >= kKnown) count(from_near);
  count(young_too);
}

}  // namespace covis
