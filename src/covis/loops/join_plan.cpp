// SPDX-License-Identifier: Apache-2.0
#include "covis/loops/join_plan.h"

#include <algorithm>
#include <limits>
#include <numbers>
#include <set>
#include <tuple>
#include <utility>

namespace covis {
namespace {

// Distinct pairs of key frames that must agree; and where more than a quarter of the views that would stand side by
// side do not see the same.
constexpr int kLeastClaims = 3, kLeastClaimsInDoubt = 5;

std::pair<uint32_t, uint32_t> ordered(uint32_t a, uint32_t b) { return std::minmax({a, b}); }

// Pairs of key frames, each counted once whichever of both claims to see the other.
int distinct(const std::vector<JoinClaim>& claims, const JoinGroup& group) {
  std::set<std::pair<KeyFrameId, KeyFrameId>> pairs;
  for (const size_t k : group.claims) pairs.insert(std::minmax({claims[k].current, claims[k].place}));
  return static_cast<int>(pairs.size());
}

// The pair that a key frame and a place belong to.
JoinedPair& pair_of(std::vector<JoinedPair>& pairs, uint32_t a, uint32_t b) {
  const auto at = std::lower_bound(pairs.begin(), pairs.end(), ordered(a, b), [](const JoinedPair& p, const auto& ids) {
    return std::pair(p.older, p.younger) < ids;
  });
  return *at;
}

std::vector<JoinedPair> all_pairs(const Map& map) {
  std::vector<JoinedPair> pairs;
  for (const Submap& a : map.submaps()) {
    for (const Submap& b : map.submaps()) {
      if (a.id < b.id) pairs.push_back({.older = a.id, .younger = b.id, .refusal = JoinRefusal::not_alike});
    }
  }
  return pairs;
}

// The refusal that came furthest stands for its pair.
void note_refusals(const Map& map, const JoinClaims& found, std::vector<JoinedPair>& pairs) {
  const auto reached = [](LoopRefusal why, const LoopEvidence& e) {
    return std::tuple(why, e.found_again, e.inliers, e.matches);
  };
  for (size_t k = 0; k < found.refused.size(); ++k) {
    const RefusedPlace& refused = found.refused[k];
    JoinedPair& pair = pair_of(pairs, map.at(refused.place).submap, map.at(found.refused_of[k]).submap);
    pair.refusal = JoinRefusal::not_verified;
    if (reached(refused.why, refused.evidence) < reached(pair.why, pair.evidence)) continue;
    pair.why = refused.why;
    pair.evidence = refused.evidence;
  }
}

// Counts the claims of a pair, the first group's against all others.
void weigh(const std::vector<JoinClaim>& claims, const std::vector<const JoinGroup*>& of, JoinedPair& pair) {
  pair.claims = distinct(claims, *of.front());
  pair.contrary = 0;
  for (size_t g = 1; g < of.size(); ++g) pair.contrary += distinct(claims, *of[g]);
  pair.evidence = claims[of.front()->claims.front()].evidence;
  if (2 * pair.contrary >= pair.claims) pair.refusal = JoinRefusal::ambiguous;
}

// Marks the pairs whose claims contradict one another, and adds the key frames of these claims to `unsure`. Returns
// whether there are any that were not marked before.
bool find_ambiguous(const std::vector<JoinClaim>& claims, const std::vector<JoinGroup>& groups,
                    std::vector<JoinedPair>& pairs, std::set<KeyFrameId>& unsure) {
  bool found = false;
  for (JoinedPair& pair : pairs) {
    if (pair.refusal == JoinRefusal::ambiguous) continue;
    std::vector<const JoinGroup*> of;  // the largest first, as they were before any claim was erased
    for (const JoinGroup& group : groups) {
      if (group.older == pair.older && group.younger == pair.younger) of.push_back(&group);
    }
    if (of.empty()) continue;
    pair.why = LoopRefusal::none;
    if (of.front()->claims.empty()) {  // all were erased; the figures stay those of before
      pair.refusal = JoinRefusal::ambiguous;
    } else {
      weigh(claims, of, pair);
    }
    if (pair.refusal != JoinRefusal::ambiguous) continue;
    found = true;
    for (const JoinGroup* group : of) {
      for (const size_t k : group->claims) unsure.insert({claims[k].current, claims[k].place});
    }
  }
  return found;
}

}  // namespace

SideBySide::SideBySide(const Map& map, const std::vector<JoinClaim>& claims, const JoinGroup& group,
                       LoopVerifier& verifier) {
  constexpr double kWay = 1, kApart = 0.3, kTurned = std::numbers::pi / 9;  // shares of the depth; radians
  struct Nearest {
    double way = std::numeric_limits<double>::infinity();
    double depth = 0;
    Sim3 S_old_young;
  };
  std::vector<Nearest> nearest;  // by slot: the claim that says where a key frame of the younger submap is
  for (const size_t k : group.claims) {
    const JoinSides side(map, claims[k]);
    const std::vector<double> ways = ways_from(map, side.in_younger);
    nearest.resize(ways.size());
    for (size_t slot = 0; slot < ways.size(); ++slot) {
      if (ways[slot] < nearest[slot].way) nearest[slot] = {ways[slot], side.depth, side.S_old_young};
    }
  }
  const std::vector<KeyFrameId> old_frames = map.key_frames(group.older);
  for (const KeyFrameId& id : map.key_frames(group.younger)) {
    const Nearest& at = nearest[id.slot];
    if (at.way * at.S_old_young.scale() > kWay * at.depth) continue;
    const SE3 T_cw = (Sim3(map.at(id).T_cw) * at.S_old_young.inverse()).as_pose();
    KeyFrameId beside;
    double least = kApart * at.depth;
    for (const KeyFrameId& other : old_frames) {
      const SE3& there = map.at(other).T_cw;
      const double apart = (there.centre() - T_cw.centre()).norm();
      if (apart > least || so3_log(there.R() * T_cw.R().transpose()).norm() > kTurned) continue;
      least = apart;
      beside = other;
    }
    if (!beside.valid()) continue;
    const LoopVerifier::View view =
        verifier.look_for(LoopPlace(map, beside), map.camera(), KeyFrameView(map, id), T_cw);
    agree += view == LoopVerifier::View::agrees;
    disagree += view == LoopVerifier::View::disagrees;
  }
}

JoinPlan::JoinPlan(const Map& map, const JoinClaims& found, LoopVerifier& verifier) : pairs(all_pairs(map)) {
  note_refusals(map, found, pairs);
  const std::vector<JoinClaim>& claims = found.claims;
  std::vector<JoinGroup> all = group_claims(map, claims);
  std::set<KeyFrameId> unsure;
  while (find_ambiguous(claims, all, pairs, unsure)) {
    for (JoinGroup& group : all) {
      std::erase_if(group.claims,
                    [&](size_t k) { return unsure.contains(claims[k].current) || unsure.contains(claims[k].place); });
    }
  }
  for (JoinGroup& group : all) {
    JoinedPair& pair = pair_of(pairs, group.older, group.younger);
    if (pair.refusal != JoinRefusal::not_alike && pair.refusal != JoinRefusal::not_verified) continue;  // decided
    if (pair.claims < kLeastClaims) {
      pair.refusal = JoinRefusal::unconfirmed;
      continue;
    }
    const SideBySide views(map, claims, group, verifier);
    pair.views_agree = views.agree;
    pair.views_disagree = views.disagree;
    const bool in_doubt = 3 * views.disagree > views.agree && pair.claims < kLeastClaimsInDoubt;
    pair.refusal = views.disagree > views.agree || in_doubt ? JoinRefusal::contradicted : JoinRefusal::none;
    pair.S_older_younger = JoinSides(map, claims[group.claims.front()]).S_old_young;
    if (pair.refusal == JoinRefusal::none) groups.push_back(std::move(group));
  }
  std::stable_sort(groups.begin(), groups.end(),
                   [](const JoinGroup& a, const JoinGroup& b) { return a.claims.size() > b.claims.size(); });
}

}  // namespace covis
