// SPDX-License-Identifier: Apache-2.0
#include "covis/loops/submap_joining.h"

#include <algorithm>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "covis/core/log.h"
#include "covis/core/reserve.h"
#include "covis/core/time.h"
#include "covis/loops/adjustment_in_pieces.h"
#include "covis/loops/join_plan.h"
#include "covis/loops/key_frame_ways.h"
#include "covis/loops/loop_consensus.h"
#include "covis/loops/loop_correction.h"
#include "covis/loops/submap_adjustment.h"
#include "covis/mapping/point_fusion.h"

namespace covis {
namespace {

// Key frames of a submap that is adjusted as one problem, at most; and of a piece of a larger one.
constexpr uint32_t kWhole = 300;
constexpr size_t kPiece = 60;

// Key frames in which the points around some place were looked for, and those that the points were taken from; sorted.
struct FusedPlace {
  std::vector<KeyFrameId> targets, group;

  bool has(KeyFrameId target, KeyFrameId place) const {
    return std::binary_search(targets.begin(), targets.end(), target) &&
           std::binary_search(group.begin(), group.end(), place);
  }
};

// Carries a plan out.
class Joining {
 public:
  Joining(SharedMap& map, const JoinSettings& settings, const JoinClaims& found, JoinPlan& plan)
      : map_(map), settings_(settings), found_(found), claims_(found.claims), plan_(plan) {
    const auto before = map.read();
    for (const Submap& submap : before->submaps()) maps_[submap.id] = {.id = submap.id, .of = {submap.id}};
    before->for_each_key_frame(
        [&](KeyFrameId id, const KeyFrame& key_frame) { at_slot(origin_, id.slot) = key_frame.submap; });
  }

  // Moves the submaps into one another's worlds.
  void join() {
    for (const JoinGroup& group : plan_.groups) join(group);
  }
  // Spreads what the claims disagree on, and fuses the points of both sides of each.
  void tie_and_fuse();
  void adjust();
  std::vector<JoinedMap> maps() const {
    std::vector<JoinedMap> list;
    for (const auto& [id, made] : maps_) list.push_back(made);
    return list;
  }

 private:
  JoinedPair& pair_of(const JoinGroup& group) {
    return *std::find_if(plan_.pairs.begin(), plan_.pairs.end(), [&](const JoinedPair& pair) {
      return pair.older == group.older && pair.younger == group.younger;
    });
  }
  bool moved_into_one(const JoinClaim& claim) const {
    const auto map = map_.read();
    return map->at(claim.current).submap == map->at(claim.place).submap;
  }
  void join(const JoinGroup& group);
  // The submap whose world becomes that of both: the older one, unless the other alone has metres for a unit.
  uint32_t kept(uint32_t a, uint32_t b) const;
  bool consistent(const JoinClaim& claim) const;
  void tie(uint32_t submap);
  int fuse(const JoinClaim& claim, std::vector<FusedPlace>& fused, FuseMemory& memory);
  void fuse_seams(uint32_t submap);

  SharedMap& map_;
  const JoinSettings& settings_;
  const JoinClaims& found_;
  const std::vector<JoinClaim>& claims_;
  JoinPlan& plan_;
  std::vector<uint32_t> origin_;          // by slot: the submap before any was joined
  std::map<uint32_t, JoinedMap> maps_;    // by id of the submap
  std::vector<const JoinGroup*> joined_;  // the groups whose claims hold
  PointFuser fuser_;
};

void Joining::join(const JoinGroup& group) {
  JoinedPair& pair = pair_of(group);
  const JoinClaim& claim = claims_[group.claims.front()];
  if (moved_into_one(claim)) {
    if (consistent(claim)) {
      joined_.push_back(&group);
    } else {
      pair.refusal = JoinRefusal::inconsistent;
    }
    return;
  }
  Loop loop;
  loop.place.key_frame = claim.place;
  loop.relation = LoopRelation::other_submap;
  loop.S_cw = claim.S_cw(*map_.read());
  const uint32_t kept_one = [&] {
    const auto map = map_.read();
    return kept(map->at(claim.current).submap, map->at(claim.place).submap);
  }();
  const std::optional<JoinedSubmap> done = join_at_loop(map_, claim.current, loop, kept_one);
  if (!done) {
    pair.refusal = JoinRefusal::inconsistent;
    return;
  }
  const auto map = map_.write();
  map->add_loop_edge(claim.current, claim.place);
  JoinedMap& into = maps_.at(map->at(claim.current).submap);
  const std::vector<uint32_t>& parts = maps_.at(done->id).of;
  into.of.insert(into.of.end(), parts.begin(), parts.end());
  std::sort(into.of.begin(), into.of.end());
  maps_.erase(done->id);
  joined_.push_back(&group);
}

uint32_t Joining::kept(uint32_t a, uint32_t b) const {
  const auto metric = [&](uint32_t submap) {
    const std::vector<uint32_t>& of = maps_.at(submap).of;
    return std::any_of(of.begin(), of.end(), [&](uint32_t part) { return found_.is_metric(part); });
  };
  const auto [older, younger] = std::minmax(a, b);
  return metric(younger) && !metric(older) ? younger : older;
}

// The way between both key frames, as they are joined by now, explains what the claim says otherwise.
bool Joining::consistent(const JoinClaim& claim) const {
  const auto map = map_.read();
  const Sim3 difference = claim.S_cw(*map) * Sim3(map->at(claim.current).T_cw).inverse();
  return opinions_agree(difference, KeyFrameWays(*map).from(claim.current)[claim.place.slot], claim.depth(*map));
}

void Joining::tie(uint32_t submap) {
  std::vector<LoopTie> ties;
  {
    const auto map = map_.read();
    for (const JoinGroup* group : joined_) {
      for (const size_t k : group->claims) {
        if (map->at(claims_[k].current).submap != submap) continue;
        ties.push_back({claims_[k].current, claims_[k].place, claims_[k].S_cw(*map)});
      }
    }
  }
  if (ties.empty()) return;
  const std::vector<uint32_t>& of = maps_.at(submap).of;
  const bool metric = std::all_of(of.begin(), of.end(), [&](uint32_t part) { return found_.is_metric(part); });
  LoopGraph graph(*map_.read(), submap, ties, metric ? settings_.sensor : Sensor::monocular);
  if (!graph.solve()) {
    log(LogLevel::warning, "the pose graph of joined maps could not be optimised; they are joined as they are");
    return;
  }
  graph.write_back(map_);
  maps_.at(submap).correction = graph.greatest_move();
}

// Looks for the points around the place in the key frames around the current one. Skips key frames in which they were
// looked for with an earlier claim.
int Joining::fuse(const JoinClaim& claim, std::vector<FusedPlace>& fused, FuseMemory& memory) {
  const int matched = fuse_matches(map_, claim.current, claim.matches);
  const auto done = [&](KeyFrameId target) {
    return std::any_of(fused.begin(), fused.end(), [&](const FusedPlace& f) { return f.has(target, claim.place); });
  };
  if (done(claim.current)) return matched;
  LoopPlace place(*map_.read(), claim.place);
  FusedPlace now;
  now.targets = beside(*map_.read(), claim.current, place);
  std::erase_if(now.targets, done);
  const int around = fuse_around(map_, now.targets, place, fuser_, &memory);
  now.group = std::move(place.group);
  std::sort(now.targets.begin(), now.targets.end());
  std::sort(now.group.begin(), now.group.end());
  fused.push_back(std::move(now));
  return matched + around;
}

// Key frames of different submaps that see the same by now, and what lies around them.
void Joining::fuse_seams(uint32_t submap) {
  std::vector<KeyFrameId> seams;
  {
    const auto map = map_.read();
    for (const KeyFrameId& id : map->key_frames(submap)) {
      const std::vector<Neighbour> neighbours = map->neighbours(id);
      const auto other = [&](const Neighbour& n) { return origin_[n.key_frame.slot] != origin_[id.slot]; };
      if (std::any_of(neighbours.begin(), neighbours.end(), other)) seams.push_back(id);
    }
  }
  FuseMemory memory;
  for (const KeyFrameId& id : seams)
    fuse_neighbours_unrefreshed(map_, id, settings_.sensor, settings_.mapper, fuser_, &memory);
  refresh_points_of(map_, seams);
}

void Joining::tie_and_fuse() {
  for (const auto& [id, made] : maps_) {
    if (made.of.size() > 1) tie(id);
  }
  std::vector<FusedPlace> fused;
  FuseMemory memory;
  for (const JoinGroup* group : joined_) {
    JoinedPair& pair = pair_of(*group);
    for (const size_t k : group->claims) pair.fused += fuse(claims_[k], fused, memory);
  }
  std::set<KeyFrameId> stale;
  for (const FusedPlace& place : fused) stale.insert(place.targets.begin(), place.targets.end());
  refresh_points_of(map_, std::vector(stale.begin(), stale.end()));
}

// Once to bring both sides together, and once more with what is found to be the same only then. The pieces of both
// times have different borders.
void Joining::adjust() {
  const int iterations = settings_.loop.ba_iterations;
  for (auto& [id, made] : maps_) {
    if (made.of.size() < 2 || iterations == 0) continue;
    const bool whole = map_.read()->submap(id)->key_frames <= kWhole;
    const auto adjust = [&](bool again) {
      if (whole) return adjust_submap(map_, id, iterations);
      const auto pieces = pieces_of(*map_.read(), id, kPiece, again);
      return adjust_in_pieces(map_, pieces, again ? iterations : (iterations + 1) / 2);
    };
    adjust(false);
    fuse_seams(id);
    if (const auto cost = adjust(true)) made.cost = *cost;
  }
}

}  // namespace

std::optional<AdjustedCost> adjust_submap(SharedMap& shared, uint32_t submap, int iterations) {
  std::optional<MapProblem> problem;
  {
    const auto map = shared.read();
    if (map->submap(submap)) problem = copy_submap(*map, map->submap(submap)->root);
  }
  if (!problem) return std::nullopt;
  BundleAdjuster adjuster;
  const BundleSummary done = adjuster.solve(problem->problem, {.iterations = iterations});
  if (!done.ok) return std::nullopt;
  classify_observations(problem->problem);
  if (!apply_submap(*problem, shared)) return std::nullopt;
  return AdjustedCost{done.initial_cost, done.final_cost};
}

JoinReport join_submaps(SharedMap& map, const JoinSettings& settings) {
  JoinReport report;
  Stopwatch watch;
  const JoinClaims found = JoinClaims::collect(*map.read(), settings.sensor, settings.loop, settings.seed);
  JoinPlan plan = [&] {
    const auto now = map.read();
    LoopVerifier verifier(*now, settings.sensor, settings.loop, settings.seed);
    return JoinPlan(*now, found, verifier);
  }();
  report.search_ms = watch.lap();
  Joining joining(map, settings, found, plan);
  joining.join();
  joining.tie_and_fuse();
  report.join_ms = watch.lap();
  joining.adjust();
  report.adjust_ms = watch.lap();
  report.pairs = std::move(plan.pairs);
  report.maps = joining.maps();
  return report;
}

}  // namespace covis
