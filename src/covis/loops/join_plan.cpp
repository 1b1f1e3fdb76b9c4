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
// Key frames that either submap must have: one that saw less shows too little to differ from a place that looks the
// same.
constexpr uint32_t kLeastKeyFrames = 5;
// One view in so many of those that would stand side by side may contradict.
constexpr int kContradictory = 20;

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

SideBySide::SideBySide(const Map& map, const KeyFrameWays& ways, const JoinClaims& found, const JoinGroup& group,
                       LoopVerifier& verifier) {
  std::vector<Link> in_younger, in_older;
  for (const size_t k : group.claims) {
    const JoinSides side(map, found.claims[k]);
    const Sim3 S_young_old = side.S_old_young.inverse();
    in_younger.push_back({side.in_younger, side.S_old_young, side.depth});
    in_older.push_back({side.in_older, S_young_old, side.depth * S_young_old.scale()});
  }
  // Depths are metres, and poses in the other submap's world are in its unit.
  const bool both_metric = found.is_metric(group.younger) && found.is_metric(group.older);
  const Pinhole camera = both_metric ? map.camera() : map.camera().without_depth();
  look(map, ways, camera, group.younger, group.older, in_younger, verifier);
  look(map, ways, camera, group.older, group.younger, in_older, verifier);
}

void SideBySide::look(const Map& map, const KeyFrameWays& ways, const Pinhole& camera, uint32_t from, uint32_t to,
                      const std::vector<Link>& links, LoopVerifier& verifier) {
  constexpr size_t kViews = 200;  // at most, spread over all (docs/notes/032-merging-maps.md)
  constexpr double kWay = 1, kApart = 0.3, kTurned = std::numbers::pi / 9;  // shares of the depth; radians
  struct Nearest {
    double way = std::numeric_limits<double>::infinity();
    const Link* link = nullptr;
  };
  std::vector<Nearest> nearest;  // by slot: the link that says where a key frame is
  for (const Link& link : links) {
    const std::vector<double> way = ways.from(link.here, kWay * link.depth / link.S_there_here.scale());
    nearest.resize(way.size());
    for (size_t slot = 0; slot < way.size(); ++slot) {
      if (way[slot] < nearest[slot].way) nearest[slot] = {way[slot], &link};
    }
  }
  struct Pair {
    KeyFrameId here, beside;
    SE3 T_cw;  // of `here` in the other world
  };
  std::vector<Pair> pairs;
  const std::vector<KeyFrameId> there = map.key_frames(to);
  for (const KeyFrameId& id : map.key_frames(from)) {
    const Link* const link = nearest[id.slot].link;
    if (!link) continue;  // none reaches that far
    Pair pair{id, {}, (Sim3(map.at(id).T_cw) * link->S_there_here.inverse()).as_pose()};
    double least = kApart * link->depth;
    for (const KeyFrameId& other : there) {
      const SE3& pose = map.at(other).T_cw;
      const double apart = (pose.centre() - pair.T_cw.centre()).norm();
      if (apart > least || so3_log(pose.R() * pair.T_cw.R().transpose()).norm() > kTurned) continue;
      least = apart;
      pair.beside = other;
    }
    if (pair.beside.valid()) pairs.push_back(pair);
  }
  const size_t step = (pairs.size() + kViews - 1) / kViews;
  for (size_t k = 0; k < pairs.size(); k += step) {
    using View = LoopVerifier::View;
    const Pair& pair = pairs[k];
    const View view = verifier.look_for(LoopPlace(map, pair.beside), camera, KeyFrameView(map, pair.here), pair.T_cw);
    agree += view == View::agrees;
    disagree += view == View::disagrees || view == View::contradicts;
    contradict += view == View::contradicts;
  }
}

JoinPlan::JoinPlan(const Map& map, const JoinClaims& found, LoopVerifier& verifier) : pairs(all_pairs(map)) {
  note_refusals(map, found, pairs);
  const std::vector<JoinClaim>& claims = found.claims;
  const KeyFrameWays ways(map);
  std::vector<JoinGroup> all = group_claims(map, ways, claims);
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
    const auto few = [&](uint32_t submap) { return map.submap(submap)->key_frames < kLeastKeyFrames; };
    if (pair.claims < kLeastClaims || few(pair.older) || few(pair.younger)) {
      pair.refusal = pair.claims < kLeastClaims ? JoinRefusal::unconfirmed : JoinRefusal::too_small;
      continue;
    }
    const SideBySide views(map, ways, found, group, verifier);
    pair.views_agree = views.agree;
    pair.views_disagree = views.disagree;
    pair.views_contradict = views.contradict;
    const bool in_doubt = 3 * views.disagree > views.agree && pair.claims < kLeastClaimsInDoubt;
    const bool elsewhere = kContradictory * views.contradict > views.agree + views.disagree;
    pair.refusal =
        views.disagree > views.agree || in_doubt || elsewhere ? JoinRefusal::contradicted : JoinRefusal::none;
    pair.S_older_younger = JoinSides(map, claims[group.claims.front()]).S_old_young;
    if (pair.refusal == JoinRefusal::none) groups.push_back(std::move(group));
  }
  std::stable_sort(groups.begin(), groups.end(),
                   [](const JoinGroup& a, const JoinGroup& b) { return a.claims.size() > b.claims.size(); });
}

}  // namespace covis
