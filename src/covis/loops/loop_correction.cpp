// SPDX-License-Identifier: Apache-2.0
#include "covis/loops/loop_correction.h"

#include <algorithm>

#include "covis/core/log.h"
#include "covis/core/time.h"
#include "covis/map/map_edit.h"

namespace covis {
namespace {

// How many of the points found again a key frame observes.
int points_found_in(const Map& map, const Loop& loop, KeyFrameId member) {
  int shared = 0;
  for (const auto& [feature, point] : loop.matches) {
    const MapPoint* p = map.find(point);
    if (!p) continue;
    shared += std::any_of(p->observations.begin(), p->observations.end(),
                          [&](const Observation& o) { return o.key_frame == member; });
  }
  return shared;
}

// The result's poses, and points, which go with their reference key frames.
void write_back(const LoopGraph& graph, SharedMap& shared) {
  const PoseGraphProblem& problem = graph.problem;
  std::vector<std::pair<KeyFrameId, size_t>> order;
  for (size_t k = 0; k < graph.frames.size(); ++k) order.emplace_back(graph.frames[k], k);
  std::sort(order.begin(), order.end());
  std::vector<std::pair<MapPointId, Eigen::Vector3d>> places;
  shared.read()->for_each_point([&](MapPointId id, const MapPoint& point) {
    const auto at = std::lower_bound(order.begin(), order.end(), std::pair{point.reference, size_t{0}});
    if (at == order.end() || at->first != point.reference) return;
    places.emplace_back(id, problem.poses[at->second].inverse() * (graph.before[at->second] * point.position_w));
  });
  MapEdit map(shared);  // all of it at once: a reader must not see half a loop
  for (size_t k = 0; k < graph.frames.size(); ++k) {
    if (!problem.fixed[k])
      map.map().correct_pose(graph.frames[k], problem.poses[k].as_pose(), 1 / problem.poses[k].scale());
  }
  for (const auto& [id, position] : places) map.set_position(id, position);
}

}  // namespace

LoopGraph::LoopGraph(const Map& map, KeyFrameId current, const Loop& loop, Sensor sensor) {
  constexpr int kSharedForEdge = 15;  // matched points a key frame of the old place must see to be tied to the new one
  problem.fix_scale = sensor != Sensor::monocular;
  frames = map.key_frames(map.at(current).submap);
  std::vector<int32_t> index;  // by slot; -1: of another submap
  map.for_each_key_frame([&](KeyFrameId id, const KeyFrame&) { index.resize(id.slot + size_t{1}, -1); });
  for (size_t k = 0; k < frames.size(); ++k) index[frames[k].slot] = static_cast<int32_t>(k);
  std::vector<uint8_t> moved(frames.size(), 0);  // 1: goes with the current key frame
  moved[static_cast<size_t>(index[current.slot])] = 1;
  for (const Neighbour& n : map.neighbours(current)) moved[static_cast<size_t>(index[n.key_frame.slot])] = 1;
  const Sim3 S_wc = Sim3(map.at(current).T_cw.inverse());
  for (size_t k = 0; k < frames.size(); ++k) {
    const SE3& T = map.at(frames[k]).T_cw;
    const bool root = map.is_root(frames[k]);  // the world stays where it is, and the points that refer to it
    before.push_back(T);
    problem.poses.push_back(moved[k] && !root ? Sim3(T) * S_wc * loop.S_cw : Sim3(T));
    problem.fixed.push_back(root);
  }
  // As it was before the loop …
  for (const auto& [a, b] : map.essential_graph()) {
    const int32_t i = index[a.slot], j = index[b.slot];
    if (i < 0) continue;
    const Sim3 S_ji = Sim3(before[static_cast<size_t>(j)] * before[static_cast<size_t>(i)].inverse());
    problem.edges.push_back({i, j, S_ji});
  }
  // … and what the loop says: the current key frame against each of the old place's that sees points found again.
  const int32_t i = index[current.slot];
  for (const KeyFrameId& member : loop.place.group) {
    const int32_t j = index[member.slot];
    if (i == j) continue;
    if (member != loop.place.key_frame && points_found_in(map, loop, member) < kSharedForEdge) continue;
    problem.edges.push_back({i, j, Sim3(before[static_cast<size_t>(j)]) * loop.S_cw.inverse()});
  }
}

double correct_loop(SharedMap& shared, KeyFrameId current, const Loop& loop, Sensor sensor) {
  LoopGraph graph(*shared.read(), current, loop, sensor);
  const Stopwatch watch;
  const PoseGraphSummary summary = optimize_pose_graph(graph.problem);
  const double ms = watch.ms();
  if (!summary.ok) log(LogLevel::warning, "a loop's pose graph could not be optimised; the loop bends its end alone");
  write_back(graph, shared);
  return ms;
}

// The submap goes to the other's world as a whole. Nothing contradicts its new place, so that there is no error to
// spread by a pose graph; the full bundle adjustment that follows does the rest.
int join_at_loop(SharedMap& shared, KeyFrameId current, const Loop& loop) {
  const auto map = shared.write();
  const KeyFrameId place = loop.place.key_frame;
  const uint32_t here = map->at(current).submap, there = map->at(place).submap;
  const Sim3 S = loop.S_cw.inverse() * Sim3(map->at(current).T_cw);  // from the current world to that of the place
  const auto key_frames = static_cast<int>(map->submap(std::max(here, there))->key_frames);
  const bool joined =
      here > there ? map->join_submaps(current, place, S) : map->join_submaps(place, current, S.inverse());
  return joined ? key_frames : 0;
}

int fuse_loop(SharedMap& shared, KeyFrameId current, const Loop& loop, PointFuser& fuser) {
  int fused = 0;
  {
    MapEdit map(shared);
    for (const auto& [feature, held] : loop.matches) {
      const MapPointId point = map->forwarded(held);
      if (!map->find(point)) continue;
      const MapPointId present = map->at(current).points[feature];
      if (present == point) continue;
      fused += present.valid() ? map.replace_point(present, point) : map.add_observation(point, current, feature);
    }
  }
  // The old place's points in the key frames around the current one.
  std::vector<KeyFrameId> targets{current};
  {
    const auto map = shared.read();
    for (const Neighbour& n : map->neighbours(current)) {
      const auto& group = loop.place.group;
      if (std::find(group.begin(), group.end(), n.key_frame) == group.end()) targets.push_back(n.key_frame);
    }
  }
  for (const KeyFrameId& target : targets) {
    fused += fuser.fuse(shared, target, loop.place.points.id,
                        {.window = 4, .keep = FuseKeep::given, .error = MatchError::not_asked});
  }
  refresh_points_of(shared, targets);
  return fused;
}

}  // namespace covis
