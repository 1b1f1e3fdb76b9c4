// SPDX-License-Identifier: Apache-2.0
#include "covis/loops/join_claims.h"

#include <algorithm>
#include <span>
#include <tuple>
#include <utility>

#include "covis/loops/claims_around.h"
#include "covis/loops/loop_consensus.h"
#include "covis/loops/loop_detector.h"
#include "covis/loops/loop_verifier.h"
#include "covis/map/camera_change.h"

namespace covis {
namespace {

// Compared at the younger one's camera of `b`. `old_way`, `young_way`: between the key frames of both claims, each in
// its own submap and unit.
bool agree(const Map& map, const JoinSides& a, const JoinSides& b, double old_way, double young_way) {
  const Sim3 T_cw = Sim3(map.at(b.in_younger).T_cw);
  const Sim3 difference = T_cw * b.S_old_young.inverse() * a.S_old_young * T_cw.inverse();
  const double scale = b.S_old_young.scale();
  return opinions_agree(difference, young_way + old_way / scale, b.depth / scale);
}

// Merges groups of claims that a claim links.
class Links {
 public:
  explicit Links(size_t count) {
    for (size_t k = 0; k < count; ++k) above_.push_back(k);
  }
  size_t top(size_t k) const {
    while (above_[k] != k) k = above_[k];
    return k;
  }
  void link(size_t a, size_t b) {
    const auto [low, high] = std::minmax({top(a), top(b)});
    above_[high] = low;
  }

 private:
  std::vector<size_t> above_;
};

}  // namespace

JoinClaim::JoinClaim(const Map& map, KeyFrameId from, const Loop& loop, const LoopEvidence& counted)
    : current(from),
      place(loop.place.key_frame),
      matches(loop.matches),
      evidence(counted),
      S_cp_(loop.S_cw * Sim3(loop.place.T_cw.inverse())),
      depth_(median_depth(loop)),
      scale_here_(map.at(from).scale),
      scale_there_(map.at(loop.place.key_frame).scale) {}

Sim3 JoinClaim::S_cw(const Map& map) const {
  const double here = map.at(current).scale / scale_here_, there = map.at(place).scale / scale_there_;
  const Sim3 S_cp(S_cp_.R(), here * S_cp_.t(), here / there * S_cp_.scale());
  return S_cp * Sim3(map.at(place).T_cw);
}

Sim3 JoinClaim::S_there_here(const Map& map) const { return S_cw(map).inverse() * Sim3(map.at(current).T_cw); }

JoinSides::JoinSides(const Map& map, const JoinClaim& claim) {
  const bool forth = map.at(claim.place).submap < map.at(claim.current).submap;
  in_older = forth ? claim.place : claim.current;
  in_younger = forth ? claim.current : claim.place;
  const Sim3 S = claim.S_there_here(map);
  S_old_young = forth ? S : S.inverse();
  depth = forth ? claim.depth(map) : claim.depth(map) * S_old_young.scale();
}

JoinClaims JoinClaims::collect(const Map& map, Sensor sensor, const LoopOptions& options, int seed) {
  JoinClaims found;
  LoopVerifier verifier(map, sensor, options, seed), any_scale(map, Sensor::monocular, options, seed);
  found.metric = metric_submaps(map);
  ClaimsAround around;
  for (const KeyFrameId& current : map.key_frames()) {
    for (const KeyFrameId& place : LoopDetector::candidates_elsewhere(map, current)) {
      if (around.suffice(map, current, place)) continue;
      const bool both_metric = found.is_metric(map.at(current).submap) && found.is_metric(map.at(place).submap);
      LoopCandidate candidate(map, current, place);
      if (!both_metric) candidate.camera = candidate.camera.without_depth();
      const LoopVerdict verdict = (both_metric ? verifier : any_scale).verify(candidate);
      if (verdict.loop) {
        found.claims.emplace_back(map, current, *verdict.loop, verdict.evidence);
        around.add(map, current, place);
      } else {
        found.refused.push_back({place, map.at(place).frame, verdict.refusal, verdict.evidence, {}, {}});
        found.refused_of.push_back(current);
      }
    }
  }
  return found;
}

std::vector<JoinGroup> group_claims(const Map& map, const KeyFrameWays& ways, const std::vector<JoinClaim>& claims) {
  std::vector<JoinSides> sides;
  for (const JoinClaim& claim : claims) sides.emplace_back(map, claim);
  Links links(claims.size());
  for (size_t a = 0; a < claims.size(); ++a) {
    std::vector<double> old_way, young_way;
    for (size_t b = 0; b < a; ++b) {
      if (map.at(sides[a].in_older).submap != map.at(sides[b].in_older).submap) continue;
      if (map.at(sides[a].in_younger).submap != map.at(sides[b].in_younger).submap) continue;
      if (links.top(a) == links.top(b)) continue;
      if (old_way.empty()) {
        old_way = ways.from(sides[a].in_older);
        young_way = ways.from(sides[a].in_younger);
      }
      if (agree(map, sides[a], sides[b], old_way[sides[b].in_older.slot], young_way[sides[b].in_younger.slot]))
        links.link(a, b);
    }
  }
  std::vector<JoinGroup> groups;
  std::vector<size_t> group_of(claims.size());
  for (size_t k = 0; k < claims.size(); ++k) {
    const size_t top = links.top(k);  // the first of its group
    if (top == k) {
      group_of[k] = groups.size();
      groups.push_back({map.at(sides[k].in_older).submap, map.at(sides[k].in_younger).submap, {}});
    }
    groups[group_of[top]].claims.push_back(k);
  }
  for (JoinGroup& group : groups) {
    std::stable_sort(group.claims.begin(), group.claims.end(), [&](size_t a, size_t b) {
      return claims[a].evidence.found_again > claims[b].evidence.found_again;
    });
  }
  std::stable_sort(groups.begin(), groups.end(), [](const JoinGroup& a, const JoinGroup& b) {
    return std::tuple(b.claims.size(), a.older, a.younger) < std::tuple(a.claims.size(), b.older, b.younger);
  });
  return groups;
}

}  // namespace covis
