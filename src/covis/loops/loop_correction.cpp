// SPDX-License-Identifier: Apache-2.0
#include "covis/loops/loop_correction.h"

#include <algorithm>
#include <optional>

#include "covis/core/log.h"
#include "covis/core/time.h"
#include "covis/loops/link_strength.h"
#include "covis/map/map_edit.h"

namespace covis {
namespace {

// How many of the points found again a key frame observes.
int points_found_in(const Map& map, const Loop& loop, KeyFrameId member) {
  int shared = 0;
  for (const auto& [feature, point] : loop.matches) {
    const MapPoint* p = map.find(point);
    shared += p && p->seen_by(member);
  }
  return shared;
}

constexpr double kLoose = 1e-3;  // weight of a motion across a weak link

}  // namespace

LoopGraph::LoopGraph(const Map& map, KeyFrameId current, const Loop& loop, Sensor sensor, int weak_link) {
  constexpr int kSharedForEdge = 15;  // matched points a key frame of the old place must see to be tied to the new one
  problem_.fix_scale = sensor != Sensor::monocular;
  take_poses(map, map.at(current).submap);
  const std::vector<Sim3> before = start_;
  moved_.push_back(index_of(current));
  for (const Neighbour& n : map.neighbours(current)) moved_.push_back(index_of(n.key_frame));
  std::erase_if(moved_, [&](int32_t k) { return problem_.fixed[static_cast<size_t>(k)] != 0; });
  std::sort(moved_.begin(), moved_.end());
  const Sim3 S_wc = Sim3(map.at(current).T_cw.inverse());
  for (const int32_t k : moved_) {
    Sim3& S = start_[static_cast<size_t>(k)];
    S = S * S_wc * loop.S_cw;
    for (const Neighbour& n : map.neighbours_above(frames_[static_cast<size_t>(k)], kCovisibilityThreshold))
      tied_.emplace_back(k, index_of(n.key_frame));
  }
  std::sort(tied_.begin(), tied_.end());
  problem_.poses = start_;
  // As it was before the loop …
  std::optional<LinkStrength> links;
  if (weak_link > 0) links.emplace(map, map.at(current).submap);
  for (const auto& [a, b] : map.essential_graph()) {
    const int32_t i = index_of(a), j = index_of(b);
    if (i < 0) continue;
    const bool loose = links && links->weakest(map.at(a).serial, map.at(b).serial) < weak_link;
    problem_.edges.push_back({i, j, motion(before, i, j), loose ? kLoose : 1});
  }
  // … and what the loop says: the current key frame against each of the old place's that sees points found again.
  const int32_t i = index_of(current);
  for (const KeyFrameId& member : loop.place.group) {
    const int32_t j = index_of(member);
    if (i == j) continue;
    if (member != loop.place.key_frame && points_found_in(map, loop, member) < kSharedForEdge) continue;
    problem_.edges.push_back({i, j, before[static_cast<size_t>(j)] * loop.S_cw.inverse()});
    tied_.insert(std::upper_bound(tied_.begin(), tied_.end(), std::pair{i, j}), {i, j});
  }
}

LoopGraph::LoopGraph(const Map& map, uint32_t submap, const std::vector<LoopTie>& ties, Sensor sensor) {
  problem_.fix_scale = sensor != Sensor::monocular;
  take_poses(map, submap);
  for (const auto& [a, b] : map.essential_graph()) {
    const int32_t i = index_of(a), j = index_of(b);
    if (i >= 0) problem_.edges.push_back({i, j, motion(start_, i, j)});
  }
  for (const LoopTie& tie : ties) {
    const int32_t j = index_of(tie.place);
    problem_.edges.push_back({index_of(tie.current), j, start_[static_cast<size_t>(j)] * tie.S_cw.inverse()});
  }
}

void LoopGraph::take_poses(const Map& map, uint32_t submap) {
  frames_ = map.key_frames(submap);
  map.for_each_key_frame([&](KeyFrameId id, const KeyFrame&) { index_.resize(id.slot + size_t{1}, -1); });
  for (size_t k = 0; k < frames_.size(); ++k) {
    index_[frames_[k].slot] = static_cast<int32_t>(k);
    start_.emplace_back(map.at(frames_[k]).T_cw);
    // The world stays where it is, and the points that refer to its root.
    problem_.fixed.push_back(map.is_root(frames_[k]));
  }
  problem_.poses = start_;
}

Sim3 LoopGraph::motion(const std::vector<Sim3>& poses, int32_t i, int32_t j) const {
  return poses[static_cast<size_t>(j)] * poses[static_cast<size_t>(i)].inverse();
}

void LoopGraph::move_beside_loop(SharedMap& shared) const {
  std::vector<std::pair<MapPointId, Eigen::Vector3d>> places;
  {
    const auto map = shared.read();
    map->for_each_point([&](MapPointId id, const MapPoint& point) {
      const int32_t k = index_of(point.reference);
      if (!std::binary_search(moved_.begin(), moved_.end(), k)) return;
      const SE3& T_cw = map->at(point.reference).T_cw;
      places.emplace_back(id, start_[static_cast<size_t>(k)].inverse() * (T_cw * point.position_w));
    });
  }
  MapEdit map(shared);
  for (const int32_t k : moved_) {
    const Sim3& S = start_[static_cast<size_t>(k)];
    map.map().correct_pose(frames_[static_cast<size_t>(k)], S.as_pose(), 1 / S.scale());
  }
  for (const auto& [id, position] : places) map.set_position(id, position);
}

int LoopGraph::tie(const Map& map) {
  const size_t there = problem_.edges.size();
  for (const int32_t k : moved_) {
    for (const Neighbour& n : map.neighbours_above(frames_[static_cast<size_t>(k)], kCovisibilityThreshold)) {
      const int32_t j = index_of(n.key_frame);
      if (std::binary_search(moved_.begin(), moved_.end(), j)) continue;
      if (std::binary_search(tied_.begin(), tied_.end(), std::pair{k, j})) continue;
      problem_.edges.push_back({k, j, motion(start_, k, j)});
    }
  }
  return static_cast<int>(problem_.edges.size() - there);
}

bool LoopGraph::solve() { return optimize_pose_graph(problem_).ok; }

double LoopGraph::greatest_move() const {
  double greatest = 0;
  for (size_t k = 0; k < start_.size(); ++k) {
    const Eigen::Vector3d before = start_[k].as_pose().centre(), after = problem_.poses[k].as_pose().centre();
    greatest = std::max(greatest, (after - before).norm());
  }
  return greatest;
}

void LoopGraph::write_back(SharedMap& shared) const {
  std::vector<std::pair<MapPointId, Eigen::Vector3d>> places;
  shared.read()->for_each_point([&](MapPointId id, const MapPoint& point) {
    const int32_t k = index_of(point.reference);
    if (k < 0) return;
    const auto at = static_cast<size_t>(k);
    places.emplace_back(id, problem_.poses[at].inverse() * (start_[at] * point.position_w));
  });
  MapEdit map(shared);  // all of it at once: a reader must not see half a graph
  for (size_t k = 0; k < frames_.size(); ++k) {
    const double growth = start_[k].scale() / problem_.poses[k].scale();
    if (!problem_.fixed[k]) map.map().correct_pose(frames_[k], problem_.poses[k].as_pose(), growth);
  }
  for (const auto& [id, position] : places) map.set_position(id, position);
}

LoopCorrection correct_loop(SharedMap& shared, KeyFrameId current, const Loop& loop, Sensor sensor, PointFuser& fuser,
                            int weak_link) {
  LoopGraph graph(*shared.read(), current, loop, sensor, weak_link);
  graph.move_beside_loop(shared);
  LoopCorrection done;
  done.fused = fuse_loop(shared, current, loop, fuser);
  done.new_edges = graph.tie(*shared.read());
  const Stopwatch watch;
  if (!graph.solve())
    log(LogLevel::warning, "a loop's pose graph could not be optimised; the loop bends its end alone");
  done.pose_graph_ms = watch.ms();
  graph.write_back(shared);
  return done;
}

// The submap goes to the other's world as a whole. Nothing contradicts its new place, so that there is no error to
// spread by a pose graph; the full bundle adjustment that follows does the rest.
std::optional<JoinedSubmap> join_at_loop(SharedMap& shared, KeyFrameId current, const Loop& loop, uint32_t kept) {
  const auto map = shared.write();
  const KeyFrameId place = loop.place.key_frame;
  const uint32_t here = map->at(current).submap, there = map->at(place).submap;
  const Sim3 S = loop.S_cw.inverse() * Sim3(map->at(current).T_cw);  // from the current world to that of the place
  const uint32_t moved = kept == there ? here : there;
  const auto key_frames = static_cast<int>(map->submap(moved)->key_frames);
  const bool joined =
      kept == there ? map->join_submaps(current, place, S) : map->join_submaps(place, current, S.inverse());
  return joined ? std::optional(JoinedSubmap{moved, kept, key_frames}) : std::nullopt;
}

std::optional<JoinedSubmap> join_at_loop(SharedMap& shared, KeyFrameId current, const Loop& loop) {
  const uint32_t older = [&] {
    const auto map = shared.read();
    return std::min(map->at(current).submap, map->at(loop.place.key_frame).submap);
  }();
  return join_at_loop(shared, current, loop, older);
}

int fuse_matches(SharedMap& shared, KeyFrameId current, const std::vector<std::pair<uint32_t, MapPointId>>& matches) {
  int fused = 0;
  MapEdit map(shared);
  for (const auto& [feature, held] : matches) {
    const MapPointId point = map->forwarded(held);
    if (!map->find(point)) continue;
    const MapPointId present = map->at(current).points[feature];
    if (present == point) continue;
    fused += present.valid() ? map.replace_point(present, point) : map.add_observation(point, current, feature);
  }
  return fused;
}

std::vector<KeyFrameId> beside(const Map& map, KeyFrameId current, const LoopPlace& place) {
  std::vector<KeyFrameId> list{current};
  for (const Neighbour& n : map.neighbours(current)) {
    if (std::find(place.group.begin(), place.group.end(), n.key_frame) == place.group.end())
      list.push_back(n.key_frame);
  }
  return list;
}

int fuse_around(SharedMap& shared, const std::vector<KeyFrameId>& targets, const LoopPlace& place, PointFuser& fuser,
                FuseMemory* memory) {
  int fused = 0;
  for (const KeyFrameId& target : targets) {
    fused += fuser.fuse(shared, target, place.points.id,
                        {.window = 4, .keep = FuseKeep::given, .error = MatchError::not_asked}, memory);
  }
  return fused;
}

int fuse_loop(SharedMap& shared, KeyFrameId current, const Loop& loop, PointFuser& fuser) {
  const int matched = fuse_matches(shared, current, loop.matches);
  const std::vector<KeyFrameId> targets = beside(*shared.read(), current, loop.place);
  const int around = fuse_around(shared, targets, loop.place, fuser);
  refresh_points_of(shared, targets);
  return matched + around;
}

}  // namespace covis
