// SPDX-License-Identifier: Apache-2.0
// Closing a recognised loop: the pose graph over Sim(3), the points carried along, and both places' points made one
// (ORB-SLAM, VII-C and VII-D). Joining two submaps that turn out to show one place.
#include <algorithm>

#include "covis/core/log.h"
#include "covis/optimization/pose_graph.h"
#include "covis/slam/loop_closer.h"

namespace covis {

void LoopCloser::correct(const View& current, const Found& found, LoopReport& report) {
  constexpr int kSharedForEdge = 15;  // matched points a key frame of the old place must see to be tied to the new one
  PoseGraphProblem graph;
  graph.fix_scale = !monocular();
  std::vector<KeyFrameId> frames;
  std::vector<SE3> before;
  {
    const auto map = map_.read();
    frames = map->key_frames(map->at(current.id).submap);
    std::vector<int32_t> index;  // by slot; -1: of another submap
    map->for_each_key_frame([&](KeyFrameId id, const KeyFrame&) { index.resize(id.slot + size_t{1}, -1); });
    for (size_t k = 0; k < frames.size(); ++k) index[frames[k].slot] = static_cast<int32_t>(k);
    std::vector<uint8_t> moved(frames.size(), 0);  // goes with the current key frame
    moved[static_cast<size_t>(index[current.id.slot])] = 1;
    for (const Neighbour& n : map->neighbours(current.id)) moved[static_cast<size_t>(index[n.key_frame.slot])] = 1;
    const Sim3 S_wc = Sim3(current.T_cw.inverse());
    for (size_t k = 0; k < frames.size(); ++k) {
      const SE3& T = map->at(frames[k]).T_cw;
      before.push_back(T);
      graph.poses.push_back(moved[k] ? Sim3(T) * S_wc * found.S_cw : Sim3(T));
      graph.fixed.push_back(map->is_root(frames[k]));  // the world stays where it is
    }
    // As it was before the loop …
    for (const auto& [a, b] : map->essential_graph()) {
      const int32_t i = index[a.slot], j = index[b.slot];
      if (i < 0) continue;
      const Sim3 S_ji = Sim3(before[static_cast<size_t>(j)] * before[static_cast<size_t>(i)].inverse());
      graph.edges.push_back({i, j, S_ji});
    }
    // … and what the loop says: the current key frame against each of the old place's that sees what was found again.
    const int32_t i = index[current.id.slot];
    for (const KeyFrameId& member : found.place.group) {
      int shared = 0;
      for (const auto& [feature, point] : found.matches) {
        const MapPoint* p = map->find(point);
        if (!p) continue;
        shared += std::any_of(p->observations.begin(), p->observations.end(),
                              [&](const Observation& o) { return o.key_frame == member; });
      }
      const int32_t j = index[member.slot];
      if (i == j || (member != found.place.key_frame && shared < kSharedForEdge)) continue;
      graph.edges.push_back({i, j, Sim3(before[static_cast<size_t>(j)]) * found.S_cw.inverse()});
    }
  }
  const Stopwatch watch;
  const PoseGraphSummary summary = optimize_pose_graph(graph);
  report.pose_graph_ms = watch.ms();
  if (!summary.ok) log(LogLevel::warning, "a loop's pose graph could not be optimised; the loop bends its end alone");

  // Points go with their reference key frames.
  const auto map = map_.write();
  std::vector<std::pair<KeyFrameId, size_t>> order;
  for (size_t k = 0; k < frames.size(); ++k) order.emplace_back(frames[k], k);
  std::sort(order.begin(), order.end());
  std::vector<std::pair<MapPointId, Eigen::Vector3d>> places;
  map->for_each_point([&](MapPointId id, const MapPoint& point) {
    const auto at = std::lower_bound(order.begin(), order.end(), std::pair{point.reference, size_t{0}});
    if (at == order.end() || at->first != point.reference) return;
    places.emplace_back(id, graph.poses[at->second].inverse() * (before[at->second] * point.position_w));
  });
  for (size_t k = 0; k < frames.size(); ++k) {
    if (!graph.fixed[k]) map->correct_pose(frames[k], graph.poses[k].as_pose(), 1 / graph.poses[k].scale());
  }
  for (const auto& [id, position] : places) map->set_position(id, position);
  for (const auto& [id, position] : places) map->refresh_point_geometry(id);
}

// The younger submap goes to the older one's world, as a whole. Nothing contradicts where it comes to lie, so that there
// is no error to spread by a pose graph; the full bundle adjustment that follows does the rest.
bool LoopCloser::join(const View& current, const Found& found, LoopReport& report) {
  const auto map = map_.write();
  const KeyFrameId place = found.place.key_frame;
  const uint32_t here = map->at(current.id).submap, there = map->at(place).submap;
  const Sim3 S = found.S_cw.inverse() * Sim3(current.T_cw);  // from the current world to that of the place
  report.merged_key_frames = static_cast<int>(map->submap(std::max(here, there))->key_frames);
  return here > there ? map->join_submaps(current.id, place, S) : map->join_submaps(place, current.id, S.inverse());
}

void LoopCloser::fuse(const View& current, const Found& found, LoopReport& report) {
  {
    const auto map = map_.write();
    for (const auto& [feature, held] : found.matches) {
      const MapPointId point = map->forwarded(held);
      if (!map->find(point)) continue;
      const MapPointId present = map->at(current.id).points[feature];
      if (present == point) continue;
      if (present.valid() ? map->replace_point(present, point) : map->add_observation(point, current.id, feature))
        ++report.fused;
      if (map->find(point)) map->refresh_point(point);
    }
  }
  // The old place's points in the key frames round the current one.
  std::vector<KeyFrameId> targets;
  {
    const auto map = map_.read();
    targets.push_back(current.id);
    for (const Neighbour& n : map->neighbours(current.id)) {
      if (std::find(found.place.group.begin(), found.place.group.end(), n.key_frame) == found.place.group.end())
        targets.push_back(n.key_frame);
    }
  }
  for (const KeyFrameId& target : targets) {
    report.fused +=
        fuser_.fuse(map_, target, found.place.points.id,
                    {.window = 4, .keep = FuseKeep::given, .error = MatchError::not_asked});
  }
  const auto map = map_.write();
  for (const KeyFrameId& target : targets) {
    const std::vector<MapPointId> points = map->at(target).points;
    for (const MapPointId& id : points) {
      if (id.valid()) map->refresh_point(id);
    }
  }
}

}  // namespace covis
